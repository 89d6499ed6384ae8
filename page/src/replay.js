// The time bar below the picture, and the recordings that can be opened.
import { Pending } from "./pending.js";
import { byId, element, setOptions, setText, throttled } from "./dom.js";
import { clock } from "./format.js";

const SEEK_MS = 100;
const SETTLE_MS = 600; // after a seek, older times that are still on their way are passed over

export class Replay {
  #ask;
  #span = null; // of the recording: start_s, end_s, events
  #playing = true;
  #pace = 1; // as told
  #pending = new Pending(() => this.#showPace());
  #bar = byId("time-bar");
  #held = false;
  #sought = -Infinity;

  /** @param {(command) => Promise} ask */
  constructor(ask) {
    this.#ask = ask;
    const seek = throttled((value) => this.#order("seek", value), SEEK_MS);
    this.#bar.addEventListener("input", () => {
      this.#sought = performance.now();
      this.#label(this.#bar.valueAsNumber);
      seek(this.#bar.valueAsNumber);
    });
    this.#bar.addEventListener("pointerdown", () => (this.#held = true));
    for (const name of ["pointerup", "pointercancel"]) addEventListener(name, () => (this.#held = false));
    byId("play").addEventListener("click", () => this.toggle());
    byId("speed").addEventListener("change", ({ target }) =>
      this.#pending.wait("speed", this.#order("speed", Number(target.value))),
    );
    byId("replay-close").addEventListener("click", () => this.#order("close"));
    byId("replay-events").addEventListener("change", (event) => this.#goTo(event.target));
    byId("recordings").addEventListener("change", (event) => this.#open(event.target));
  }

  /** Play or pause; nothing where no recording is shown. */
  async toggle() {
    if (!this.#span) return;
    this.#showPlaying(!this.#playing);
    const done = await this.#order(this.#playing ? "play" : "pause");
    if (!done) this.#showPlaying(!this.#playing);
  }

  hello({ replay, recordings }) {
    this.#span = replay ?? null;
    byId("replay-bar").hidden = !replay;
    // a live skin that can be gone back to tells its recordings; one that is shown by itself has none
    byId("replay-close").hidden = !recordings?.length;
    this.#showRecordings(recordings ?? []);
    if (!replay) return;
    const { start_s: start, end_s: end, events } = replay;
    Object.assign(this.#bar, { min: start, max: end, value: start });
    this.#pace = 1;
    this.#showPace();
    this.#showPlaying(true);
    this.#label(start);
    setText(byId("replay-end"), clock(end));
    this.#showEvents(start, end, events ?? []);
  }

  controls({ replay }) {
    if (!replay) return;
    this.#showPlaying(replay.playing !== false);
    this.#pace = replay.speed;
    this.#pending.settled();
    this.#showPace();
  }

  /** The recording is at this time, s. */
  at(seconds) {
    if (!this.#span || !Number.isFinite(seconds)) return;
    if (this.#held || performance.now() - this.#sought < SETTLE_MS) return;
    this.#bar.value = seconds;
    this.#label(seconds);
  }

  #order(what, value) {
    return this.#ask({ do: "replay", what, ...(value === undefined ? {} : { value }) });
  }

  #label(seconds) {
    setText(byId("replay-now"), clock(seconds));
    this.#bar.setAttribute("aria-valuetext", `${clock(seconds)} of ${clock(this.#span?.end_s)}`);
  }

  #showPace() {
    if (this.#pending.has("speed")) return;
    const speeds = [...byId("speed").options];
    const near = speeds.find(({ value }) => Math.abs(Number(value) - this.#pace) < 1e-6);
    if (near && byId("speed").value !== near.value) byId("speed").value = near.value;
  }

  #showPlaying(playing) {
    this.#playing = playing;
    byId("play").classList.toggle("playing", playing);
    byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  }

  #showRecordings(names) {
    const select = byId("recordings");
    const first = names.length ? "Open a recording …" : "No recording yet";
    setOptions(select, [["", first], ...names.map((name) => [name, name])]);
    select.value = "";
    select.disabled = names.length === 0;
    select.title = names.length ? "Shown in this browser alone" : "Record something first";
  }

  async #open(select) {
    const name = select.value;
    select.value = "";
    if (!name) return;
    select.setAttribute("aria-busy", "true");
    await this.#order("open", name);
    select.removeAttribute("aria-busy");
  }

  #showEvents(start, end, events) {
    const marks = events.map(([time, text]) => {
      const mark = element("i", { title: `${clock(time)} ${text}` });
      mark.style.left = `${(100 * (time - start)) / Math.max(end - start, 1e-9)}%`;
      return mark;
    });
    byId("replay-marks").replaceChildren(...marks);
    const pairs = events.map(([time, text]) => [time, `${clock(time)}  ${text}`]);
    setOptions(byId("replay-events"), [["", "Events"], ...pairs]);
    byId("replay-events").value = "";
    byId("replay-events").disabled = events.length === 0;
  }

  #goTo(select) {
    if (select.value !== "") this.#order("seek", Number(select.value));
    this.#sought = -Infinity;
    select.value = "";
  }
}

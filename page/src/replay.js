// The time bar below the picture: of a recording, or of the newest half minute of a live skin.
import { Pending } from "./pending.js";
import { byId, element, setOptions, setText, throttled } from "./dom.js";
import { saveText } from "./export.js";
import { clock, fixed } from "./format.js";
import { LookBack } from "./lookback.js";
import { Strip } from "./strip.js";

const SEEK_MS = 100;
const SETTLE_MS = 600; // after a seek, older times that are still on their way are passed over
const STRIP_MS = 250; // the strip of a live skin is drawn this often
const ARROWS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }; // readings, on the bar
const PLAY_MS = 50; // from moment to moment while the half minute is played

export class Replay {
  #ask;
  #query;
  #showMoment;
  #span = null; // of the recording: start_s, end_s, events
  #columns = "";
  #name = "";
  #playing = true;
  #looping = false;
  #pace = 1; // as told
  #pending = new Pending(() => this.#showPace());
  #bar = byId("time-bar");
  #strip = new Strip(byId("time-strip"));
  #back = new LookBack();
  #at = 0; // s of the half minute that is shown, while it is held
  #clock = null; // that plays it
  #drawn = -Infinity;
  #held = false; // the knob
  #sought = -Infinity;
  #relative = false;

  /**
   * @param {(command) => Promise<boolean>} ask
   * @param {(command) => Promise<object|null>} query the answer; null where it was refused
   * @param {(moment: object, isNow?: boolean) => void} showMoment of a live skin
   */
  constructor(ask, query, showMoment) {
    this.#ask = ask;
    this.#query = query;
    this.#showMoment = showMoment;
    const seek = throttled((value) => this.#order("seek", value), SEEK_MS);
    this.#bar.addEventListener("input", () => {
      const value = this.#bar.valueAsNumber;
      if (!this.#span) return this.#lookAt(this.#back.end + value);
      this.#sought = performance.now();
      this.#label(value);
      seek(value);
    });
    this.#bar.addEventListener("keydown", (event) => {
      const count = ARROWS[event.key];
      if (!count) return;
      event.preventDefault(); // the bar's own steps are hundredths of a second
      this.step(count);
    });
    this.#bar.addEventListener("pointerdown", () => (this.#held = true));
    for (const name of ["pointerup", "pointercancel"]) addEventListener(name, () => (this.#held = false));
    const clicks = {
      play: () => this.toggle(), "step-back": () => this.step(-1), "step-on": () => this.step(1), loop: () => this.loop(),
      "export-csv": () => this.saveContacts(), "replay-close": () => (this.#span ? this.#order("close") : this.live()),
    };
    for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener("click", act);
    byId("speed").addEventListener("change", ({ target }) => {
      if (this.#span) this.#pending.wait("speed", this.#order("speed", Number(target.value)));
      else this.#pace = Number(target.value);
    });
    byId("replay-events").addEventListener("change", (event) => this.#goTo(event.target));
    byId("recordings").addEventListener("change", (event) => this.#open(event.target));
  }

  /** Is the past of a live skin shown? */
  get lookingBack() {
    return this.#back.held;
  }

  /** Play or pause; a live skin is paused, and played on from where it is looked at. */
  async toggle() {
    if (!this.#span) return this.#toggleLive();
    this.#showPlaying(!this.#playing);
    const done = await this.#order(this.#playing ? "play" : "pause");
    if (!done) this.#showPlaying(!this.#playing);
  }

  /** Go so many readings on, or back. */
  step(count) {
    if (this.#span) return this.#order("step", count);
    if (!this.#hold()) return undefined;
    this.#stop();
    const place = this.#back.placeAt(this.#at) + count;
    return this.#showPlace(Math.min(Math.max(place, 0), this.#back.length - 1));
  }

  /** Begin anew at the end, or not any more. */
  async loop() {
    this.#showLoop(!this.#looping);
    if (this.#span && !(await this.#order("loop", this.#looping))) this.#showLoop(!this.#looping);
  }

  /** A live skin is shown as it is now again. */
  live() {
    if (!this.lookingBack) return;
    this.#stop();
    this.#back.release();
    this.#showLive();
    this.#showMoment(this.#back.moment(this.#back.length - 1), true);
    this.#drawBack(true);
  }

  hello({ replay, recordings, columns, name }) {
    this.#span = replay ?? null;
    this.#columns = columns ?? "";
    this.#name = name || "skin";
    this.#stop();
    this.#back.clear();
    this.#strip.show(null);
    document.body.classList.toggle("is-replay", Boolean(replay));
    document.body.classList.toggle("no-recordings", !recordings?.length);
    // a live skin that can be gone back to tells its recordings; one that is shown by itself has none
    byId("replay-close").hidden = !replay || !recordings?.length;
    this.#showRecordings(recordings ?? []);
    this.#pace = 1;
    this.#showPace();
    this.#showLoop(false);
    this.#showPlaying(true);
    if (!replay) return this.#showLive();
    const { start_s: start, end_s: end, events } = replay;
    Object.assign(this.#bar, { min: start, max: end, value: start });
    this.#bar.setAttribute("aria-label", "Time of the recording, s");
    this.#label(start);
    setText(byId("replay-end"), clock(end));
    this.#showEvents(start, end, events ?? []);
  }

  controls({ replay }) {
    if (!replay) return;
    this.#showPlaying(replay.playing !== false);
    this.#showLoop(Boolean(replay.loop));
    this.#pace = replay.speed;
    this.#pending.settled();
    this.#showPace();
  }

  /** Force and touches of the whole recording. */
  timeline({ times, force, touches }) {
    if (!this.#span) return;
    const { start_s: start, end_s: end, events } = this.#span;
    this.#strip.show({ start, end, times, force, touches });
    const begins = touches.map(([begin], i) => [begin, `touch ${i + 1} begins`]);
    this.#showEvents(start, end, [...(events ?? []), ...begins].sort(([a], [b]) => a - b));
  }

  /** The recording is at this time, s. */
  at(seconds) {
    if (!this.#span || !Number.isFinite(seconds)) return;
    if (this.#held || performance.now() - this.#sought < SETTLE_MS) return;
    this.#bar.value = seconds;
    this.#label(seconds);
  }

  /** Keep an update of a live skin, of a time in s and so many bytes. */
  keep(time, head, arrays, bytes) {
    if (this.#span) return;
    this.#relative = Boolean(head.relative);
    this.#back.add(time, head, arrays, bytes);
    if (!this.lookingBack) this.#drawBack();
  }

  /** Another theme: the strip has other colours. */
  recolour() {
    this.#strip.draw();
  }

  /** Save the contacts of the time bar's span, as the library writes them. */
  async saveContacts() {
    const answer = this.#span ? await this.#query({ do: "replay", what: "contacts" }) : null;
    const text = answer?.csv ?? [this.#columns, ...this.#back.rows(), ""].join("\n");
    if (!this.#span || answer) saveText(`${this.#name}-contacts.csv`, text);
  }

  // the half minute

  #hold() {
    if (this.lookingBack) return true;
    if (!this.#back.hold()) return false;
    this.#at = this.#back.end;
    byId("replay-close").hidden = false;
    document.body.classList.add("looking-back");
    this.#showPlaying(false);
    this.#label(0);
    return true;
  }

  #toggleLive() {
    if (!this.lookingBack) return void (this.#hold() && this.#showPlace(this.#back.length - 1));
    if (this.#clock) return this.#stop();
    this.#showPlaying(true);
    this.#clock = setInterval(() => this.#playOn(), PLAY_MS);
    return undefined;
  }

  #playOn() {
    this.#at += (this.#pace * PLAY_MS) / 1e3;
    if (this.#at <= this.#back.end) return this.#lookAt(this.#at, true);
    if (!this.#looping) return this.live();
    return this.#lookAt(this.#back.start, true);
  }

  #stop() {
    clearInterval(this.#clock);
    this.#clock = null;
    if (this.lookingBack) this.#showPlaying(false);
  }

  #lookAt(time, plays = false) {
    if (!this.#hold()) return;
    if (!plays) this.#stop();
    this.#showPlace(this.#back.placeAt(time), time);
  }

  #showPlace(place, time) {
    const moment = this.#back.moment(place);
    this.#at = time ?? moment.time;
    this.#bar.value = this.#at - this.#back.end;
    this.#label(this.#at - this.#back.end);
    this.#showMoment(moment);
  }

  #showLive() {
    document.body.classList.remove("looking-back");
    byId("replay-marks").replaceChildren(); // of a recording
    Object.assign(this.#bar, { min: -this.#back.seconds, max: 0, value: 0 });
    this.#bar.setAttribute("aria-label", "Time before now, s");
    byId("replay-close").hidden = true;
    this.#showPlaying(true);
    setText(byId("replay-end"), "now");
    setText(byId("replay-now"), `−${this.#back.seconds} s`);
    this.#bar.setAttribute("aria-valuetext", "now");
  }

  #drawBack(now = false) {
    if (!now && performance.now() - this.#drawn < STRIP_MS) return;
    this.#drawn = performance.now();
    const end = this.#back.end;
    this.#strip.show({ start: end - this.#back.seconds, end, unit: this.#relative ? "rel." : "N", ...this.#back.outline() });
  }

  // the recording

  #order(what, value) {
    return this.#ask({ do: "replay", what, ...(value === undefined ? {} : { value }) });
  }

  #label(seconds) {
    const text = this.#span ? clock(seconds) : `${fixed(seconds, 1)} s`;
    setText(byId("replay-now"), text);
    this.#bar.setAttribute("aria-valuetext", this.#span ? `${text} of ${clock(this.#span.end_s)}` : text);
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
    const words = playing ? "Pause" : "Play";
    byId("play").setAttribute("aria-label", this.#span || !playing ? words : "Pause and look back");
  }

  #showLoop(on) {
    this.#looping = on;
    byId("loop").setAttribute("aria-pressed", String(on));
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
    const happened = this.#span.events ?? [];
    const marks = happened.map(([time, text]) => {
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

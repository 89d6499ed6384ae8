// The panel of the estimate: settings of the engine, as the server has them in force.
import { Pending } from "./pending.js";
import { byId, clamp, element, setOptions, setText } from "./dom.js";
import { bytes, clock, fixed } from "./format.js";
import { notice } from "./notices.js";

const SELECTS = { resolution: "resolution", solver: "solver" };
const NUMBERS = { deadline_us: "deadline", smoothing_ms: "smoothing", threshold_N: "threshold" };
const NAMES = {
  resolution: "Resolution", solver: "Solver", deadline_us: "Deadline", smoothing_ms: "Smoothing",
  threshold_N: "Threshold", focus: "Focus", tare: "Tare", record: "Recording", press: "Pressing",
};
const SETTLED_MS = 700; // after the last key the number is sent, Enter or not

export class Controls {
  #ask;
  #scene;
  #now = null; // the newest message
  #pending = new Pending(() => this.#showValues());
  #drawing = false;
  #patchName;

  /**
   * @param {(command) => Promise} ask sends a command; refusals are shown by it
   * @param {object} scene
   * @param {(i: number) => string} patchName
   */
  constructor(ask, scene, patchName) {
    this.#ask = ask;
    this.#scene = scene;
    this.#patchName = patchName;
    for (const [what, id] of Object.entries(SELECTS)) {
      byId(id).addEventListener("change", () => this.#set(what, typed(byId(id).value)));
    }
    for (const [what, id] of Object.entries(NUMBERS)) this.#bindNumber(what, byId(id));
    byId("focus").addEventListener("click", () => this.draw(!this.#drawing));
    byId("focus-clear").addEventListener("click", () => this.#set("focus", null));
    byId("tare").addEventListener("click", () => this.tare());
    byId("record").addEventListener("click", () => this.record());
  }

  tare() {
    if (!byId("tare").disabled) this.#busyButton(byId("tare"), { do: "tare" });
  }

  record() {
    const on = !this.#now?.recording;
    if (!byId("record").disabled) this.#busyButton(byId("record"), { do: "record", on });
  }

  /** Draw a focus window on the skin, or stop doing so. */
  draw(on) {
    this.#drawing = on && !byId("focus").disabled;
    byId("focus").setAttribute("aria-pressed", String(this.#drawing));
    setText(byId("focus"), this.#drawing ? "Drag on the skin …" : "Draw focus");
    this.#scene.setMode(this.#drawing ? "focus" : "press");
  }

  get drawing() {
    return this.#drawing;
  }

  /** A window was drawn: {patch, low: [x, y], high: [x, y]}, m. */
  focusDrawn(value) {
    this.draw(false);
    this.#set("focus", value);
  }

  /** Take over what is in force, as the server or another browser has set it. */
  show(controls) {
    this.#now = controls;
    this.#pending.settled();
    this.#showValues();
    const off = controls.off ?? {};
    this.#showFocus(controls.focus ?? null, off.focus);
    able(byId("tare"), off.tare);
    this.#showRecording(controls.recording ?? null, off.record);
    this.#showOff(off);
    const busy = controls.busy ?? "";
    setText(byId("busy"), busy);
    byId("busy").title = busy;
  }

  /** What is in force, except where something else was asked and is still on its way. */
  #showValues() {
    const now = this.#now ?? {};
    const off = now.off ?? {};
    for (const [what, id] of Object.entries(SELECTS)) this.#showSelect(what, byId(id), now[what], off[what]);
    for (const [what, id] of Object.entries(NUMBERS)) this.#showNumber(what, byId(id), now[what], off[what]);
    this.#showWaiting(byId("focus"), this.#pending.has("focus"));
  }

  #showWaiting(control, waiting) {
    if (waiting) control.setAttribute("aria-busy", "true");
    else control.removeAttribute("aria-busy");
  }

  #showSelect(what, select, told, why) {
    const pending = this.#pending.has(what);
    this.#showWaiting(select, pending || told?.preparing != null);
    able(select, why ?? (told ? null : "the engine does not tell it"));
    if (!told) return;
    const options = (told.options ?? [told.value]).map((value) => [value, String(value)]);
    setOptions(select, what === "solver" ? solverOptions(options) : options);
    const wanted = String(told.preparing ?? told.value);
    if (!pending && select.value !== wanted) select.value = wanted;
  }

  #showNumber(what, input, told, why) {
    const pending = this.#pending.has(what);
    this.#showWaiting(input, pending);
    able(input, why ?? (told ? null : "the engine does not tell it"));
    if (!told) return;
    const [lo, hi] = (told.range ?? []).map(short);
    if (Number.isFinite(lo)) input.min = lo;
    if (Number.isFinite(hi)) input.max = hi;
    input.dataset.inForce = short(told.value);
    if (!input.dataset.typing && !pending) input.value = short(told.value);
    if (!why && Number.isFinite(hi)) input.title = `${lo} to ${hi}`;
  }

  #showFocus(focus, why) {
    able(byId("focus"), why);
    able(byId("focus-clear"), why ?? (focus ? null : "there is no window"));
    setText(byId("focus-text"), focus ? this.#focusWords(focus) : "");
    this.#scene.setFocus?.(focus);
  }

  #focusWords({ patch, low, high }) {
    const sides = [0, 1].map((k) => fixed(1e3 * (high[k] - low[k]), 0));
    const name = typeof patch === "number" ? this.#patchName(patch) : patch;
    return `focus ${sides.join(" × ")} mm on ${name}`;
  }

  #showRecording(recording, why) {
    const button = byId("record");
    able(button, why);
    button.setAttribute("aria-pressed", String(Boolean(recording)));
    setText(byId("record-label"), recording ? "Stop" : "Record");
    const text = recording ? `${clock(recording.seconds)} · ${bytes(recording.bytes)}` : "";
    setText(byId("record-text"), text);
    byId("record-text").title = recording?.file ?? "";
    byId("record-off").hidden = !why;
    setText(byId("record-off"), why ? sentence(why) : "");
  }

  /** Say once for each reason which settings cannot be changed. */
  #showOff(off) {
    const reasons = new Map();
    for (const [what, why] of Object.entries(off)) {
      if (["press", "record"].includes(what) || !(what in NAMES)) continue;
      reasons.set(why, [...(reasons.get(why) ?? []), NAMES[what]]);
    }
    const list = byId("controls-off");
    list.hidden = reasons.size === 0;
    const all = Object.keys(NAMES).length - 2;
    const made = [...reasons].map(([why, names]) =>
      element("li", { text: names.length >= all ? sentence(why) : `${names.join(", ")}: ${why}` }),
    );
    list.replaceChildren(...made);
  }

  #bindNumber(what, input) {
    let timer = null;
    const send = () => {
      clearTimeout(timer);
      if (!input.dataset.typing) return;
      delete input.dataset.typing;
      const value = this.#within(what, input);
      const news = this.#pending.has(what) || value !== Number(input.dataset.inForce);
      if (Number.isFinite(value) && news) this.#set(what, value);
      else input.value = input.dataset.inForce;
    };
    input.addEventListener("input", () => {
      input.dataset.typing = "yes";
      clearTimeout(timer);
      timer = setTimeout(send, SETTLED_MS);
    });
    input.addEventListener("change", send);
  }

  /** The number of a field, within its limits; says so where it was not. */
  #within(what, { valueAsNumber: value, min, max }) {
    if (!Number.isFinite(value) || min === "" || max === "") return value;
    const nearest = clamp(value, Number(min), Number(max));
    if (nearest !== value) notice("info", `${NAMES[what]} can be ${min} to ${max}: taken as ${nearest}.`);
    return nearest;
  }

  #set(what, value) {
    const control = byId(SELECTS[what] ?? NUMBERS[what] ?? what);
    if (what in NUMBERS) control.value = value;
    this.#showWaiting(control, true);
    return this.#pending.wait(what, this.#ask({ do: "set", what, value }));
  }

  async #busyButton(button, command) {
    button.setAttribute("aria-busy", "true");
    await this.#ask(command);
    button.removeAttribute("aria-busy");
  }
}

const SOLVERS = {
  auto: ["Use", "Auto"],
  contact: ["Use", "ContactFit"],
  nonnegative: ["Use", "NonNegative"],
  gaussian: ["Study", "Gaussian, linear"],
  tikhonov: ["Study", "Tikhonov, the paper's"],
  "pseudo-inverse": ["Study", "Pseudo-inverse, the paper's"],
  inverse: ["Study", "Inverse, the paper's"],
};

/** Solvers in two groups, for use and for study, as [value, label, group]; those to use first. */
export function solverOptions(options) {
  const order = Object.keys(SOLVERS);
  const place = ([value]) => (value in SOLVERS ? order.indexOf(value) : order.length);
  const known = options.map(([value, label]) => [value, SOLVERS[value]?.[1] ?? label, SOLVERS[value]?.[0] ?? "Study"]);
  return known.sort((one, other) => place(one) - place(other));
}

/** Enable a control, or disable it and say why. */
export function able(control, why) {
  control.disabled = Boolean(why);
  if (control.dataset.title === undefined) control.dataset.title = control.title;
  control.title = why ? sentence(why) : control.dataset.title;
}

/** A number without the dust of conversions: 400, not 400.00000000000006. */
function short(value) {
  return Number(Number(value).toPrecision(6));
}

/** Values of options as they are on the wire: numbers as numbers. */
function typed(value) {
  return value !== "" && Number.isFinite(Number(value)) ? Number(value) : value;
}

function sentence(text) {
  return text.charAt(0).toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".");
}

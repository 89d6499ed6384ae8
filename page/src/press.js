// The panel of the virtual indenter, and what gestures on the skin do with it.
import { Pending } from "./pending.js";
import { able } from "./controls.js";
import { byId, clamp, setOptions, setText } from "./dom.js";
import { PressGestures } from "./gestures.js";
import { notice } from "./notices.js";

const RING_PX = 12; // from one ring of places that are tried to the next
const ROUND = 16; // places on a ring
const SHAPES = { ball: "Ball", flat: "Flat end" };

export class PressPanel {
  #ask;
  #scene;
  #gestures;
  #limits = null; // press of the newest hello
  #off = null;
  #busy = null; // what the server does, in words
  #mode = "live";
  #playing = null; // the scene that plays, as told
  #pending = new Pending(() => this.#showScene());

  /** @param {(command) => Promise} ask @param {object} scene */
  constructor(ask, scene) {
    this.#ask = ask;
    this.#scene = scene;
    const mine = `${Date.now().toString(36).slice(-5)}${Math.floor(Math.random() * 1296).toString(36)}.`;
    this.#gestures = new PressGestures(ask, () => this.tool, mine);
    this.#bindSlider("radius", () => this.#toolChanged());
    this.#bindSlider("force", () => this.#toolChanged(true));
    byId("shape").addEventListener("change", () => this.#toolChanged());
    byId("lift").addEventListener("click", () => this.liftAll());
    byId("press-middle").addEventListener("click", () => this.pressMiddle());
    byId("press-scene").addEventListener("change", ({ target }) =>
      this.#pending.wait("scene", this.#ask({ do: "scene", name: target.value })),
    );
  }

  /** The indenter of the panel: {shape, radius, force} in m and N. */
  get tool() {
    return {
      shape: byId("shape").value,
      radius: byId("radius").valueAsNumber / 1e3,
      force: byId("force").valueAsNumber,
    };
  }

  /** Can the skin be pressed at all? */
  get able() {
    return this.#limits !== null && !this.#off;
  }

  /** Another skin, or the same one anew. */
  hello({ press, mode }) {
    this.#limits = press ?? null;
    this.#mode = mode;
    this.#off = null;
    if (press) this.#setLimits(press);
    this.#showAble();
  }

  /** Why pressing is off, if it is; the scene that plays, if that is told. */
  controls({ off, scene, busy }) {
    this.#off = off?.press ?? null;
    this.#busy = busy ?? null;
    this.#playing = scene;
    this.#pending.settled();
    this.#showScene();
    this.#showAble();
  }

  /** From the scene: phase "begin", "move" or "end". */
  gesture(phase, { patch, position, id, event } = {}) {
    if (!this.able && phase === "begin") return;
    const at = {
      patch,
      position: position ? Array.from(position) : null,
      id: this.#own(id),
      x: event?.clientX ?? 0,
      y: event?.clientY ?? 0,
      shift: Boolean(event?.shiftKey),
      // when it happened: a page that is busy hears of it later, and would take a tap for a hold
      time: (event?.timeStamp || performance.now()) / 1e3,
    };
    // a second finger or the system took the gesture away: it was no press
    const taken = phase === "end" && event && event.type !== "pointerup";
    const does = { begin: "down", move: "move", end: taken ? "cancel" : "up" };
    this.#gestures[does[phase]](at);
  }

  /** Press where the middle of the picture is, without a pointer. */
  pressMiddle() {
    if (!this.able) return;
    const hit = this.#nearMiddle();
    if (hit) this.#gestures.tap({ patch: hit.patch, position: Array.from(hit.position) });
    else notice("info", "no skin is in the picture: Home shows the whole of it");
  }

  /** Skin in the middle of the picture, or what is nearest to it: a curved skin may be hollow there. */
  #nearMiddle() {
    const { clientWidth: width, clientHeight: height } = this.#scene.canvas;
    for (let reach = 0; reach < Math.hypot(width, height) / 2; reach += RING_PX) {
      for (let k = 0; k < (reach ? ROUND : 1); k += 1) {
        const angle = (2 * Math.PI * k) / ROUND - Math.PI / 2;
        const [x, y] = [width / 2 + reach * Math.cos(angle), height / 2 + reach * Math.sin(angle)];
        const inside = x >= 0 && y >= 0 && x < width && y < height;
        const hit = inside ? this.#scene.pick(x, y) : null;
        if (hit?.position) return hit;
      }
    }
    return null;
  }

  /** Tell what presses now; presses that wait for something are shown, with what they wait for. */
  seen(truths) {
    const why = this.#busy;
    const waiting = why ? this.#gestures.missing(truths.map(({ id }) => id)) : [];
    this.#scene.setWaiting(waiting.map((press) => ({ ...press, why })));
  }

  /** There is a new connection: what was pressed over the one before cannot be named any more. */
  forget() {
    this.#gestures.forget();
  }

  /** The page is being left: nobody could lift its presses any more. */
  leave() {
    this.#gestures.liftMine();
  }

  liftAll() {
    if (this.able) this.#gestures.liftAll();
  }

  /** The server names a press with the number of the browser before its id. */
  #own(id) {
    if (id == null) return null;
    return this.#gestures.ids.find((mine) => id === mine || String(id).endsWith(`-${mine}`)) ?? null;
  }

  /** Why the skin cannot be pressed from here; null if it can. */
  get #why() {
    if (this.#mode === "replay") return "a recording cannot be pressed";
    if (this.#limits) return this.#off;
    return this.#off ?? "a real skin is pressed by hand";
  }

  #showAble() {
    const why = this.#why;
    for (const id of ["shape", "press-scene", "radius", "radius-slider", "force", "force-slider", "lift", "press-middle"]) {
      able(byId(id), why);
    }
    const scenes = this.#limits?.scenes ?? [];
    if (!why) able(byId("press-scene"), scenes.length ? null : "this skin has no scenes");
    document.body.classList.toggle("no-press", !this.#limits);
    byId("press-panel").classList.toggle("is-off", Boolean(why));
    setText(byId("press-note"), why ?? "click stays · hold lifts · Shift adds");
  }

  #showScene() {
    if (typeof this.#playing !== "string" || this.#pending.has("scene")) return;
    if (byId("press-scene").value !== this.#playing) byId("press-scene").value = this.#playing;
  }

  #setLimits({ shapes, radius, force, scenes }) {
    setOptions(byId("shape"), shapes.map((name) => [name, SHAPES[name] ?? name]));
    setOptions(byId("press-scene"), (scenes ?? []).map((name) => [name, name]));
    limit("radius", radius.map((value) => value * 1e3));
    limit("force", force);
    this.#toolChanged();
  }

  #toolChanged(force = false) {
    const tool = this.tool;
    this.#scene.setTool(tool);
    if (force) this.#gestures.setForce(tool.force);
  }

  #bindSlider(id, changed) {
    const box = byId(id);
    const slider = byId(`${id}-slider`);
    slider.addEventListener("input", () => {
      box.value = slider.value;
      changed();
    });
    box.addEventListener("input", () => {
      if (!box.validity.valid || box.value === "") return;
      slider.value = box.value;
      changed();
    });
    box.addEventListener("change", () => {
      const value = Number.isFinite(box.valueAsNumber) ? box.valueAsNumber : slider.valueAsNumber;
      box.value = slider.value = clamp(value, Number(box.min), Number(box.max));
      changed();
    });
  }
}

/** Limits of a number and its slider; what was chosen stays if it is within them. */
function limit(id, [lo, hi, usual]) {
  const box = byId(id);
  const slider = byId(`${id}-slider`);
  const step = (hi - lo) / 200;
  const chosen = box.value === "" ? usual : clamp(box.valueAsNumber, lo, hi);
  for (const input of [box, slider]) {
    input.min = Number(lo.toPrecision(6));
    input.max = Number(hi.toPrecision(6));
  }
  box.step = "any";
  slider.step = Number(step.toPrecision(2));
  box.value = Number(chosen.toPrecision(6));
  slider.value = box.value;
}

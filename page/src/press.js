// The panel of the virtual indenter, and what gestures on the skin do with it.
import { Pending } from "./pending.js";
import { able } from "./controls.js";
import { byId, clamp, element, setOptions, setText, touches } from "./dom.js";
import { PressGestures } from "./gestures.js";
import { notice } from "./notices.js";

const RING_PX = 12; // from one ring of places that are tried to the next
const ROUND = 16; // places on a ring
const SHAPES = { ball: "Ball", flat: "Flat end", finger: "Finger", L: "Letter L", T: "Letter T" };
const NAMED = { finger: "Finger", L: "L", T: "T" }; // on their buttons, in place of a radius
const SETTLED_MS = 500; // after the last change of a tool it is asked for, if it is not ready
const MOVED_MS = 400; // after a key moved a press; older news of its place are passed over
const OFF_M = 2e-3; // from where a key moves a press to what is seen there: not the same skin

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
  #common = {}; // radii, m, by shape
  #tools = { ready: [], preparing: [] }; // as told
  #truths = [];
  #moved = -Infinity; // when a key moved a press, ms
  #timer = null;

  /** @param {(command) => Promise} ask @param {object} scene */
  constructor(ask, scene) {
    this.#ask = ask;
    this.#scene = scene;
    const mine = `${Date.now().toString(36).slice(-5)}${Math.floor(Math.random() * 1296).toString(36)}.`;
    this.#gestures = new PressGestures(ask, () => this.tool, mine);
    bindSlider("radius", () => this.#toolChanged(), {
      position: (value) => this.#nearestSize(value),
      value: (position) => this.#sizes[position] ?? byId("radius").valueAsNumber,
    });
    bindSlider("force", () => this.#toolChanged(true));
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

  /** Radii, mm, that the slider goes to: of the panel's shape what is ready, or is prepared anyhow. */
  get #sizes() {
    const { shape } = this.tool;
    const ready = this.#tools.ready.filter((each) => each.shape === shape).map(({ radius }) => radius);
    const [lo, hi] = this.#limits?.radius ?? [0, Infinity];
    const radii = [...(this.#common[shape] ?? []), ...ready].filter((radius) => radius >= lo && radius <= hi);
    return [...new Set(radii.map(millimetres))].sort((a, b) => a - b);
  }

  #nearestSize(value) {
    const off = this.#sizes.map((each) => Math.abs(each - value));
    return off.indexOf(Math.min(...off));
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
  controls({ off, scene, busy, tools }) {
    this.#tools = tools ?? { ready: [], preparing: [] };
    this.#off = off?.press ?? null;
    this.#busy = busy ?? null;
    this.#playing = scene;
    this.#pending.settled();
    this.#showScene();
    this.#showAble();
    this.#showTools();
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
      alt: Boolean(event?.altKey),
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

  /**
   * Move the newest press by metres to the right and up, as the picture shows the skin.
   * @returns {boolean} whether there is one
   */
  shift(right, up) {
    const press = this.#gestures.newest;
    if (!press || !this.able) return false;
    const normal = this.#truths.find(({ id }) => this.#own(id) === press.id)?.normal;
    const { elements } = this.#scene.view.camera.matrixWorld;
    const wanted = [0, 1, 2].map((k) => right * elements[k] + up * elements[4 + k]);
    const step = along(wanted, normal ?? [0, 0, 1], Math.hypot(right, up));
    const position = press.position.map((value, k) => value + step[k]);
    const { x, y } = this.#scene.project(position);
    const hit = this.#scene.pickAtRest(x, y);
    if (hit?.position && Math.hypot(...hit.position.map((value, k) => value - position[k])) < OFF_M) {
      this.#moved = performance.now();
      this.#gestures.shift(press.id, hit.patch, position);
    }
    return true;
  }

  /** Press the newest press harder, by newtons; whether there is one. */
  harder(newtons) {
    if (!this.#gestures.newest || !this.able) return false;
    const box = byId("force");
    box.value = Number((box.valueAsNumber + newtons).toFixed(3));
    box.dispatchEvent(new Event("change"));
    return true;
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
    this.#truths = truths;
    if (performance.now() - this.#moved > MOVED_MS) {
      for (const { id, patch, position } of truths) this.#gestures.settle(this.#own(id), patch, position);
    }
    const why = this.#busy && this.#share !== null ? `${this.#busy}, ${percent(this.#share)}` : this.#busy;
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
    for (const button of byId("tools").querySelectorAll("button")) able(button, why);
    for (const id of ["shape", "press-scene", "radius", "radius-slider", "force", "force-slider", "lift", "press-middle"]) {
      able(byId(id), why);
    }
    const scenes = this.#limits?.scenes ?? [];
    if (!why) able(byId("press-scene"), scenes.length ? null : "this skin has no scenes");
    document.body.classList.toggle("no-press", !this.#limits);
    byId("press-panel").classList.toggle("is-off", Boolean(why));
    setText(byId("press-note"), why ?? (touches() ? "tap stays · hold lifts" : "click stays · hold lifts · Shift adds"));
  }

  #showScene() {
    if (typeof this.#playing !== "string" || this.#pending.has("scene")) return;
    if (byId("press-scene").value !== this.#playing) byId("press-scene").value = this.#playing;
  }

  #setLimits({ shapes, radius, force, scenes, common, friction }) {
    this.#gestures.friction = friction ?? 0;
    this.#common = common ?? {};
    this.#makeTools();
    setOptions(byId("shape"), shapes.map((name) => [name, SHAPES[name] ?? name]));
    setOptions(byId("press-scene"), (scenes ?? []).map((name) => [name, name]));
    limit("radius", radius.map((value) => value * 1e3));
    limit("force", force);
    this.#toolChanged();
  }

  #toolChanged(force = false) {
    const tool = this.tool;
    this.#scene.setTool(tool);
    this.#showTools();
    if (force) return this.#gestures.setForce(tool.force);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#prepare(), SETTLED_MS);
  }

  /** Have the panel's tool prepared before it presses, if it is not ready. */
  #prepare() {
    const { shape, radius } = this.tool;
    if (!this.able || this.#isReady(this.tool) || !Number.isFinite(radius)) return;
    this.#ask({ do: "tool", shape, radius });
  }

  #isReady(tool) {
    return this.#tools.ready.some((each) => same(each, tool));
  }

  /** The part of the panel's tool that is prepared; null where it is ready, or nobody prepares it. */
  get #share() {
    return this.#tools.preparing.find((each) => same(each, this.tool))?.share ?? null;
  }

  /** A button for each of the common tools. */
  #makeTools() {
    const kinds = Object.entries(this.#common).flatMap(([shape, radii]) => radii.map((radius) => ({ shape, radius })));
    const made = kinds.map(({ shape, radius }) => {
      const [name, size] = [SHAPES[shape] ?? shape, `${millimetres(radius)} mm`];
      const button = element(
        "button",
        { type: "button", class: "tool", "data-testid": `tool-${shape}-${millimetres(radius)}`, "aria-label": `${name}, radius ${size}` },
        shape in NAMED ? null : element("i", { class: `tool-shape ${shape}`, "aria-hidden": "true" }),
        element("span", { text: NAMED[shape] ?? String(millimetres(radius)) }),
      );
      Object.assign(button.dataset, { shape, radius });
      button.addEventListener("click", () => this.#choose(shape, radius));
      return button;
    });
    byId("tools").replaceChildren(...made);
  }

  #choose(shape, radius) {
    byId("shape").value = shape;
    byId("radius").value = millimetres(radius);
    this.#toolChanged();
  }

  /** Which tool is chosen, which are ready, and how far the chosen one is. */
  #showTools() {
    const tool = this.tool;
    for (const button of byId("tools").querySelectorAll("button")) {
      const its = { shape: button.dataset.shape, radius: Number(button.dataset.radius) };
      const ready = this.#isReady(its);
      button.setAttribute("aria-pressed", String(same(its, tool)));
      button.classList.toggle("is-waiting", !ready);
      if (!button.disabled) button.title = `${button.getAttribute("aria-label")}${ready ? "" : ": is being prepared"}`;
    }
    const [slider, sizes] = [byId("radius-slider"), this.#sizes];
    Object.assign(slider, { min: 0, max: Math.max(sizes.length - 1, 0), step: 1 });
    slider.value = this.#nearestSize(byId("radius").valueAsNumber);
    slider.setAttribute("aria-valuetext", `${sizes[slider.value] ?? "–"} mm`);
    this.#showProgress(this.#limits && !this.#isReady(tool) ? this.#share : null);
  }

  #showProgress(share) {
    byId("tool-progress").hidden = share === null;
    if (share === null) return;
    const { shape, radius } = this.tool;
    byId("tool-share").value = share;
    setText(byId("tool-words"), `${SHAPES[shape] ?? shape} of ${millimetres(radius)} mm: being prepared, ${percent(share)}`);
  }
}

/** A number box and its slider; the slider's positions may stand for other numbers. */
function bindSlider(id, changed, { position = (value) => value, value = (at) => at } = {}) {
  const [box, slider] = [byId(id), byId(`${id}-slider`)];
  slider.addEventListener("input", () => {
    box.value = value(slider.valueAsNumber);
    changed();
  });
  box.addEventListener("input", () => {
    if (!box.validity.valid || box.value === "") return;
    slider.value = position(box.valueAsNumber);
    changed();
  });
  box.addEventListener("change", () => {
    const typed = Number.isFinite(box.valueAsNumber) ? box.valueAsNumber : value(slider.valueAsNumber);
    box.value = clamp(typed, Number(box.min), Number(box.max));
    slider.value = position(box.valueAsNumber);
    changed();
  });
}

function same(one, other) {
  return one.shape === other.shape && millimetres(one.radius) === millimetres(other.radius);
}

/** Radii are prepared in steps of 0.1 mm. */
function millimetres(radius) {
  return Math.round(radius * 1e4) / 10;
}

function percent(share) {
  return `${Math.round(100 * share)} %`;
}

/** A vector of a length in the plane with a normal, as near as can be to the one that is wanted. */
function along(wanted, normal, length) {
  const height = wanted.reduce((sum, value, k) => sum + value * normal[k], 0);
  const flat = wanted.map((value, k) => value - height * normal[k]);
  const size = Math.hypot(...flat);
  return size > 1e-9 ? flat.map((value) => (value * length) / size) : [0, 0, 0];
}

/** Limits of a number and its slider; what was chosen stays if it is within them. */
function limit(id, [lo, hi, usual]) {
  const box = byId(id);
  const slider = byId(`${id}-slider`);
  const chosen = box.value === "" ? usual : clamp(box.valueAsNumber, lo, hi);
  for (const input of id === "radius" ? [box] : [box, slider]) {
    input.min = Number(lo.toPrecision(6));
    input.max = Number(hi.toPrecision(6));
  }
  box.step = "any";
  slider.step = Number(((hi - lo) / 200).toPrecision(2));
  box.value = Number(chosen.toPrecision(6));
  slider.value = box.value;
}

/**
 * What a pointer does: on the skin it presses (or draws the focus window), elsewhere it turns the
 * picture; right button, middle button and two fingers move it, the wheel and pinching zoom.
 */

const TURN = 0.0085; // rad per px
const GRASP = 14; // px around a standing press within which it is taken hold of

export class Pointer {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import("./scene.js").SkinScene} scene
   */
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.scene = scene;
    /** @type {Map<number, {x: number, y: number}>} pointers that are down */
    this.down = new Map();
    /** What the first of them does. */
    this.doing = null;
    const on = (name, handle, options) => canvas.addEventListener(name, handle, options);
    on("pointerdown", (event) => this.#begin(event));
    on("pointermove", (event) => this.#move(event));
    on("pointerup", (event) => this.#end(event));
    on("pointercancel", (event) => this.#end(event));
    on("pointerleave", () => this.scene.hover(null));
    on("contextmenu", (event) => event.preventDefault());
    on("wheel", (event) => this.#wheel(event), { passive: false });
  }

  #at(event) {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  #begin(event) {
    const at = this.#at(event);
    this.down.set(event.pointerId, at);
    this.canvas.setPointerCapture(event.pointerId);
    this.scene.hover(null);
    if (this.down.size === 2) {
      this.#stop(event);
      this.doing = { kind: "pinch" };
      return;
    }
    if (this.down.size > 2) return;
    if (event.button === 1) event.preventDefault();
    this.doing = event.button === 0 ? this.#choose(at, event) : { kind: "pan" };
  }

  #choose(at, event) {
    const { scene } = this;
    if (scene.mode === "focus") {
      const hit = scene.pick(at.x, at.y);
      if (hit) return { kind: "focus", patch: hit.patch, first: hit, last: hit };
    } else if (scene.pressable) {
      const press = this.#press(at);
      if (press) {
        scene.handlers.onPress?.("begin", { ...press.place, id: press.id, event });
        return press;
      }
    }
    return { kind: "orbit" };
  }

  /** Takes hold of a press that stands there, or begins one. */
  #press(at) {
    const { scene } = this;
    const standing = scene.pressNear(at.x, at.y, GRASP);
    const place = standing ?? scene.pick(at.x, at.y);
    if (!place) return null;
    // The finger may be on a dent that is drawn deep: keep hold of the place, not of the pixel
    const seen = scene.project(place.position);
    return {
      kind: "press",
      id: standing?.id ?? null,
      place: { patch: place.patch, position: place.position },
      offset: { x: seen.x - at.x, y: seen.y - at.y },
    };
  }

  #move(event) {
    const at = this.#at(event);
    const before = this.down.get(event.pointerId);
    if (!before) {
      if (this.down.size === 0 && event.pointerType !== "touch") this.scene.hover(at);
      return;
    }
    const dx = at.x - before.x;
    const dy = at.y - before.y;
    const { doing, scene } = this;
    if (doing?.kind === "pinch") this.#pinch(event.pointerId, at);
    this.down.set(event.pointerId, at);
    if (doing?.kind === "orbit") scene.orbit(dx * TURN, dy * TURN);
    else if (doing?.kind === "pan") scene.pan(dx, dy);
    else if (doing?.kind === "press") this.#drag(doing, at, event);
    else if (doing?.kind === "focus") this.#stretch(doing, at);
  }

  #drag(doing, at, event) {
    const place = this.scene.pickAtRest(at.x + doing.offset.x, at.y + doing.offset.y);
    if (!place) return;
    doing.place = { patch: place.patch, position: place.position };
    this.scene.handlers.onPress?.("move", { ...doing.place, id: doing.id, event });
  }

  #stretch(doing, at) {
    const hit = this.scene.pickAtRest(at.x, at.y);
    if (!hit || hit.patch !== doing.patch) return;
    doing.last = hit;
    this.scene.sketchFocus(windowOf(doing));
  }

  #pinch(id, at) {
    const [one, other] = [...this.down.entries()].map(([key, place]) => (key === id ? at : place));
    const [oneBefore, otherBefore] = [...this.down.values()];
    const long = Math.hypot(one.x - other.x, one.y - other.y);
    const longBefore = Math.hypot(oneBefore.x - otherBefore.x, oneBefore.y - otherBefore.y);
    if (longBefore > 8 && long > 8) this.scene.zoom(long / longBefore);
    this.scene.pan(
      (one.x + other.x - oneBefore.x - otherBefore.x) / 2,
      (one.y + other.y - oneBefore.y - otherBefore.y) / 2,
    );
  }

  #end(event) {
    if (!this.down.delete(event.pointerId)) return;
    if (this.doing?.kind === "pinch") {
      if (this.down.size === 0) this.doing = null;
      return;
    }
    if (this.down.size === 0) this.#stop(event);
  }

  #stop(event) {
    const { doing, scene } = this;
    this.doing = null;
    if (doing?.kind === "press") {
      scene.handlers.onPress?.("end", { ...doing.place, id: doing.id, event });
    } else if (doing?.kind === "focus") {
      const drawn = windowOf(doing);
      scene.sketchFocus(null);
      const wide = Math.min(drawn.high[0] - drawn.low[0], drawn.high[1] - drawn.low[1]);
      // A click without a drag takes the window away
      scene.handlers.onFocus?.(wide > 0.5e-3 ? drawn : null);
    }
  }

  #wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : 1;
    this.scene.zoom(Math.exp(-event.deltaY * lines * 0.0012));
  }
}

function windowOf({ patch, first, last }) {
  return {
    patch,
    low: [Math.min(first.x, last.x), Math.min(first.y, last.y)],
    high: [Math.max(first.x, last.x), Math.max(first.y, last.y)],
  };
}

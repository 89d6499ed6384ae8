/**
 * The skin in three dimensions: what the server answers, drawn; what the pointer does, reported.
 *
 * Nothing is drawn unless something changed, and at most once per picture of the screen.
 */

import * as THREE from "three";
import { fixed, forceUnit } from "../format.js";
import { OrbitCamera } from "./camera.js";
import { mapTable } from "./colours.js";
import { FINEST } from "./grid.js";
import { Marks } from "./marks.js";
import { Patches } from "./patches.js";
import { Picture } from "./picture.js";
import { Pointer } from "./pointer.js";
import { THEMES } from "./theme.js";

/** Of the skin's size, kept free above it in the home view: arrows and labels are there. */
const HEADROOM = 0.03;

/**
 * @typedef {object} Handlers
 * @property {(phase: "begin"|"move"|"end", press: {patch: number, position: number[],
 *   id: string|null, event: PointerEvent}) => void} [onPress] position: in the display frame, m;
 *   id: of the standing press that was taken hold of
 * @property {(window: {patch: number, low: number[], high: number[]}|null) => void} [onFocus]
 *   the window that was drawn, in metres of the patch's plane; null: a click, take it away
 * @property {(text: string) => void} [onPick] what is under the pointer, empty for nothing
 */

export class SkinScene {
  /**
   * @param {HTMLElement} container the canvas fills it
   * @param {Handlers} handlers
   */
  constructor(container, handlers = {}) {
    // Colours of the map go to the screen as they are
    THREE.ColorManagement.enabled = false;
    this.container = container;
    this.handlers = handlers;
    this.mode = "press";
    this.skin = "";
    this.focusOf = null;
    this.pressable = false;
    this.toolOf = { shape: "ball", radius: 0.004, force: 1 };
    this.picture = new Picture(container, () => this.#fill());
    this.canvas = this.picture.canvas;
    this.table = colourTexture();
    this.patches = new Patches(this.table, this.picture.software ? FINEST / 2 : FINEST);
    this.marks = new Marks(this.patches);
    this.view = new OrbitCamera();
    this.root = new THREE.Scene();
    this.root.add(this.patches.group, this.marks.group);
    this.map = "viridis";
    this.waiting = [];
    this.requested = 0;
    this.drawn = 0;
    this.draw = this.draw.bind(this);
    this.setTheme("dark");
    this.setColours({ lo: 0, hi: 1 });
    this.pointer = new Pointer(this.canvas, this);
  }

  #fill() {
    const { width, height, ratio } = this.picture;
    this.view.resize(width, height);
    this.marks.setScreen(width, height, ratio);
    this.patches.setSize(ratio / this.view.pixel(1));
    // At once: a canvas that was resized is empty until it is drawn
    this.draw();
  }

  /** @param {object} hello of the server; with another skin everything begins anew */
  setSkin(hello) {
    const skin = JSON.stringify([hello.name, hello.size, hello.patches]);
    if (skin !== this.skin) {
      this.patches.reset(hello.patches);
      this.view.moved = false;
      this.focusOf = null;
    }
    this.skin = skin;
    this.marks.size = hello.size || 0.1;
    this.marks.contacts = [];
    this.marks.truth = [];
    this.marks.shapes = [];
    this.marks.waiting = [];
    this.marks.focus = this.focusOf;
    this.marks.tool = null;
    this.pressable = Boolean(hello.press);
    this.redraw();
  }

  /** @param {object} head @param {Record<string, ArrayLike<number>>} arrays by name */
  setGeometry(head, arrays) {
    const known = this.patches.all.get(head.patch)?.surface;
    this.patches.setGeometry(head, arrays);
    if (!known) this.#frame();
    this.redraw();
  }

  #frame() {
    const { points, normal } = this.patches.subject(HEADROOM * this.marks.size);
    if (points.length > 0) this.view.setSubject(points, normal);
  }

  /**
   * @param {object} head of an update
   * @param {ArrayLike<number>[]} arrays in the order of head.arrays
   */
  update(head, arrays) {
    const full = head.quantity === "taxels" ? head.range?.[1] : null;
    for (const entry of head.patches ?? []) this.patches.update(entry, arrays, full);
    this.marks.contacts = head.contacts ?? [];
    this.marks.unit = forceUnit(head.relative);
    this.marks.truth = head.truth ?? [];
    this.marks.shapes = head.shapes?.images ?? [];
    this.redraw();
  }

  /** @param {{id: string, position: number[], why: string}[]} presses that are still to come */
  setWaiting(presses) {
    if (presses.length || this.marks.waiting.length) this.redraw();
    this.marks.waiting = presses;
  }

  /** @param {Iterable<Element>} elements that stand over the picture: labels keep off them */
  setCovered(elements) {
    const { left, top } = this.canvas.getBoundingClientRect();
    const boxes = [...elements].map((each) => each.getBoundingClientRect()).filter(({ width }) => width > 0);
    this.marks.covered = boxes.map((box) => ({ x: box.x - left, y: box.y - top, width: box.width, height: box.height }));
    this.redraw();
  }

  /** @returns {Promise<void>} fulfilled when what was set so far is on the screen */
  whenDrawn() {
    return new Promise((resolve) => {
      this.waiting.push(resolve);
      this.redraw();
    });
  }

  /** @param {"dark"|"light"} name */
  setTheme(name) {
    const theme = THEMES[name] ?? THEMES.dark;
    const own = getComputedStyle(this.container).getPropertyValue("--scene-background").trim();
    this.picture.setBackground(own || theme.background);
    this.marks.setTheme(theme);
    this.patches.theme = theme;
    this.theme = theme;
    this.#recolour();
    this.patches.refresh();
    this.redraw();
  }

  #recolour() {
    this.table.image.data.set(mapTable(this.map, this.theme));
    this.table.needsUpdate = true;
  }

  /** @param {number} times how much deeper than real the dents are drawn */
  setExaggeration(times) {
    this.patches.exaggeration = times;
    this.patches.refresh();
    this.redraw();
  }

  /** @param {{lo: number, hi: number, map?: string}} bar ends of the colour bar, in its unit */
  setColours({ lo, hi, map }) {
    if (map) {
      this.map = map;
      this.#recolour();
    }
    this.patches.bar = [lo, hi];
    this.patches.refresh();
    this.redraw();
  }

  /** @param {"pressure"|"deformation"|"uncertainty"|"taxels"} quantity */
  setQuantity(quantity) {
    this.patches.quantity = quantity;
    this.patches.refresh();
    this.redraw();
  }

  showTaxels(shown) {
    this.patches.taxels = Boolean(shown);
    this.patches.refresh();
    this.redraw();
  }

  showLabels(shown) {
    this.marks.labelled = Boolean(shown);
    this.redraw();
  }

  /** @param {{shape: string, radius: number, force: number}} tool m, N */
  setTool(tool) {
    this.toolOf = { ...this.toolOf, ...tool };
  }

  /** @param {"press"|"focus"} mode what dragging on the skin does */
  setMode(mode) {
    this.mode = mode;
    this.hover(null);
  }

  /** @param {{patch: number, low: number[], high: number[]}|null} window that the engine uses */
  setFocus(window) {
    this.focusOf = window;
    this.marks.focus = window;
    this.redraw();
  }

  /** A window while it is being drawn; null: the engine's again. */
  sketchFocus(window) {
    this.marks.focus = window ?? this.focusOf;
    this.redraw();
  }

  orbit(dx, dy) {
    this.view.orbit(dx, dy);
    this.redraw();
  }

  pan(dx, dy) {
    this.view.pan(dx, dy);
    this.redraw();
  }

  zoom(factor) {
    this.view.zoom(factor);
    this.redraw();
  }

  home() {
    this.#frame();
    this.view.home();
    this.redraw();
  }

  /**
   * @param {ArrayLike<number>} position in the display frame, m
   * @returns {{x: number, y: number}} CSS px in the canvas
   */
  project(position) {
    const seen = new THREE.Vector3(...position).project(this.view.camera);
    return { x: (seen.x + 1) * 0.5 * this.view.width, y: (1 - seen.y) * 0.5 * this.view.height };
  }

  /** The place of the skin that is seen at a CSS pixel of the canvas; its position is at rest. */
  pick(x, y) {
    return this.#hit(x, y, false);
  }

  /** The same as if nothing pressed: what a drag follows, lest a dent moves what made it. */
  pickAtRest(x, y) {
    return this.#hit(x, y, true);
  }

  #hit(x, y, rest) {
    const { camera, width, height } = this.view;
    const ray = new THREE.Vector3((x / width) * 2 - 1, 1 - (y / height) * 2, 0.5);
    ray.unproject(camera).sub(camera.position).normalize();
    return this.patches.hit(camera.position.toArray(), ray.toArray(), rest);
  }

  /** The colour that is on the screen at a CSS pixel of the canvas, sRGB 0..255; draws anew. */
  colourAt(x, y) {
    this.draw();
    return this.picture.colourAt(x, y);
  }

  /** The press that stands within `reach` px of a pixel, as {id, patch, position}, or null. */
  pressNear(x, y, reach) {
    const place = { position: [0, 0, 0], normal: [0, 0, 1] };
    for (const { id, patch, position, x: px, y: py } of this.marks.truth) {
      this.patches.at(patch, px, py, place, true); // where its arrow ends
      const seen = this.project(place.position);
      if (Math.hypot(seen.x - x, seen.y - y) <= reach) return { id, patch, position };
    }
    return null;
  }

  /** @param {{x: number, y: number}|null} at where the pointer is, null: away */
  hover(at) {
    const hit = at ? this.pick(at.x, at.y) : null;
    const presses = this.pressable && this.mode === "press";
    this.marks.tool = hit && presses ? { ...hit, radius: this.toolOf.radius } : null;
    this.canvas.style.cursor = hit && (presses || this.mode === "focus") ? "crosshair" : "grab";
    this.handlers.onPick?.(hit ? this.#describe(hit) : "");
    this.redraw();
  }

  #describe({ patch, x, y }) {
    const { name } = this.patches.all.get(patch).about;
    return `${name}  x ${fixed(1e3 * x)} mm  y ${fixed(1e3 * y)} mm`;
  }

  redraw() {
    if (!this.requested) this.requested = requestAnimationFrame(this.draw);
  }

  /** Draws now. */
  draw() {
    cancelAnimationFrame(this.requested);
    this.requested = 0;
    this.marks.draw(this.view);
    this.picture.render(this.root, this.view.camera);
    this.drawn += 1;
    for (const resolve of this.waiting.splice(0)) resolve();
  }
}

function colourTexture() {
  const table = new THREE.DataTexture(new Uint8Array(4 * 256), 256, 1);
  return table;
}

/**
 * What is drawn on the skin besides itself: contacts that were found, presses that are known, the
 * window that is looked at, and the tool under the pointer.
 */

import * as THREE from "three";
import { fixed, orElse } from "../format.js";
import { Arrows, arrowLength } from "./arrows.js";
import { Labels } from "./labels.js";
import { Lines } from "./lines.js";
import { ON_SKIN } from "./theme.js";

const AROUND = 48; // segments of a ring
const EDGE = 24; // segments of a side of the focus window
const DASHES = 14;

const colour = (text) => new THREE.Color(text);

export class Marks {
  /** @param {import("./patches.js").Patches} patches */
  constructor(patches) {
    this.patches = patches;
    this.lines = new Lines();
    this.arrows = new Arrows();
    this.labels = new Labels();
    this.group = new THREE.Group();
    this.group.add(this.lines.mesh, this.arrows.mesh, this.labels.group);
    this.contacts = [];
    this.unit = "N"; // of their forces
    this.truth = [];
    this.waiting = []; // presses that are asked for: {id, position, why}
    this.focus = null;
    this.tool = null;
    this.size = 0.1;
    this.labelled = true;
    this.onSkin = Object.fromEntries(
      Object.entries(ON_SKIN).map(([name, text]) => [name, colour(text)]),
    );
    this.place = { position: [0, 0, 0], normal: [0, 0, 1] };
    this.from = { position: [0, 0, 0], normal: [0, 0, 1] };
    this.wanted = [];
    this.kept = [];
    this.seen = new THREE.Vector3();
    this.tail = new THREE.Vector3();
  }

  setScreen(width, height, ratio) {
    this.lines.setScreen(width * ratio, height * ratio, ratio);
    this.arrows.setScreen(width * ratio, height * ratio, ratio);
    this.labels.setScreen(width, height, ratio);
  }

  setTheme(theme) {
    this.theme = theme;
    this.arrows.setCasing(theme.background);
    const { contact, truth, muted } = theme;
    this.tint = { contact: colour(contact), truth: colour(truth), old: colour(muted) };
  }

  /**
   * Writes all marks for this picture.
   *
   * @param {import("./camera.js").OrbitCamera} view
   * @param {number} now ms
   * @returns {boolean} whether labels are up to date; otherwise draw again a little later
   */
  draw(view, now) {
    this.lines.clear();
    this.arrows.clear();
    this.wanted.length = 0;
    this.kept.length = 0;
    for (const press of this.truth) this.#truth(press, view);
    for (const press of this.waiting) this.#waits(press, view);
    for (const contact of this.contacts) this.#contact(contact, view);
    for (const [i, patch] of this.patches.all) this.#missing(i, patch, view);
    if (this.focus) this.#window(this.focus);
    if (this.tool) this.#ring(this.tool, this.tool.radius, this.onSkin.tool, { opacity: 0.9 });
    this.lines.finish();
    this.arrows.finish();
    return this.labels.set(this.labelled ? this.wanted : [], this.kept, this.theme, now);
  }

  #contact(contact, view) {
    this.#outline(contact, contact.old ? this.tint.old : this.onSkin.contact);
    const place = this.#rest(contact);
    const tail = this.#arrow(place, contact, contact.old ? this.tint.old : this.tint.contact, false);
    this.#keep(place.position, Math.sqrt((contact.area || 1e-5) / Math.PI), view);
    for (const part of [0.5, 1]) {
      const along = (value, i) => value + part * (tail.getComponent(i) - value);
      this.#keep(place.position.map(along), 0, view);
    }
    const spread = contact.force_std > 0 ? ` ± ${contact.force_std.toFixed(2)}` : "";
    this.#label(`c${contact.key}`, tail, view, {
      title: `${contact.force.toFixed(2)} ${this.unit}${spread}${contact.maybe ? ` · ${orElse(contact.maybe)}?` : ""}`,
      detail: `#${contact.track}  ${contact.old ? (contact.seen ?? "not of now") : this.#where(contact)}`,
      accent: contact.old ? this.theme.muted : this.theme.contact,
      side: 1,
    });
  }

  #truth(press, view) {
    const place = this.#rest(press);
    const tail = this.#arrow(place, press, this.tint.truth, true);
    this.#label(`t${press.id}`, tail, view, {
      title: `truth ${press.force.toFixed(2)} N`,
      detail: this.#where(press),
      accent: this.theme.truth,
      side: -1,
    });
    this.#keep(place.position, press.contact_radius || 0.002, view);
    const radius = press.contact_radius || press.radius || 0.002;
    this.#ring(press, radius, this.onSkin.truth, { dashed: true, rest: true });
  }

  /** Place of a contact on the skin at rest: the bottom of its dent, drawn deeper than it is, stands beside it. */
  #rest({ patch, x, y, position, normal }) {
    const { place } = this;
    if (!this.patches.at(patch, x, y, place, true)) {
      place.position = [...position];
      place.normal = [...normal];
    }
    return place;
  }

  /** A press that is asked for and does not press yet. */
  #waits({ id, position, why }, view) {
    this.#label(`w${id}`, this.seen.set(...position).clone(), view, {
      title: "the press waits",
      detail: why,
      accent: this.theme.truth,
      side: -1,
    });
  }

  #missing(i, { answer, waiting, surface, about }, view) {
    if (answer !== "missing" || waiting || !surface) return;
    const [x, y, z] = surface.nodes.sphere.centre;
    this.#label(`m${i}`, this.seen.set(x, y, z).clone(), view, {
      title: about.name,
      detail: "no reading",
      accent: this.theme.muted,
      side: 0,
    });
  }

  #label(key, at, view, label) {
    const [x, y] = this.#pixel(at, view);
    if (Math.abs(this.seen.z) > 1) return;
    this.wanted.push({ key, ...label, anchorX: x, anchorY: y, opacity: 1 });
  }

  /** A place in words; the patch is named where there are several. */
  #where({ patch, x, y }) {
    const { all } = this.patches;
    const name = all.size > 1 ? `${all.get(patch)?.about.name ?? patch}  ` : "";
    return `${name}x ${fixed(1e3 * x)}  y ${fixed(1e3 * y)} mm`;
  }

  /** Labels are not to hide a contact, nor its arrow. */
  #keep(position, radius, view) {
    const [x, y] = this.#pixel(this.seen.set(...position), view);
    const distance = this.seen.set(...position).distanceTo(view.camera.position);
    const reach = 6 + radius / view.pixel(distance);
    this.kept.push({ x: x - reach, y: y - reach, width: 2 * reach, height: 2 * reach });
  }

  /** CSS px of a place; its depth stays in `seen.z`. */
  #pixel(at, view) {
    const { seen } = this;
    seen.copy(at).project(view.camera);
    return [(seen.x + 1) * 0.5 * view.width, (1 - seen.y) * 0.5 * view.height];
  }

  /** @returns {THREE.Vector3} where the arrow begins */
  #arrow({ position, normal }, { patch, force }, tint, hollow) {
    // On a small patch of a large skin, an arrow of the patch's own size
    const side = this.patches.all.get(patch)?.about.side || this.size;
    const long = arrowLength(force, Math.min(this.size, 1.8 * side));
    this.tail.set(...position).addScaledVector(this.seen.set(...normal), long);
    this.arrows.add(this.tail.toArray(), position, tint, hollow);
    return this.tail;
  }

  /** A circle on the skin. */
  #ring({ patch, x, y }, radius, tint, { dashed = false, opacity = 1, rest = false } = {}) {
    this.#path(AROUND, patch, tint, { dashed, opacity, width: 2, rest }, (t, out) => {
      out[0] = x + radius * Math.cos(2 * Math.PI * t);
      out[1] = y + radius * Math.sin(2 * Math.PI * t);
    });
  }

  /** A rectangle of the patch's plane, on the skin. */
  #window({ patch, low, high }) {
    const corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
    for (let i = 0; i < 4; i += 1) {
      const [ax, ay] = corners[i];
      const [bx, by] = corners[(i + 1) % 4];
      this.#path(EDGE, patch, this.onSkin.focus, { width: 2 }, (t, out) => {
        out[0] = ax + (bx - ax) * t;
        out[1] = ay + (by - ay) * t;
      });
    }
  }

  #path(count, patch, tint, { dashed = false, rest = false, ...look }, place) {
    const at = [0, 0];
    let [a, b] = [this.from, this.place];
    place(0, at);
    let inside = this.patches.at(patch, at[0], at[1], a, rest);
    for (let i = 1; i <= count; i += 1) {
      place(i / count, at);
      const next = this.patches.at(patch, at[0], at[1], b, rest);
      const dash = dashed ? [((i - 1) / count) * DASHES, (i / count) * DASHES] : null;
      if (inside || next) this.lines.add(a.position, b.position, tint, { ...look, dash });
      [a, b, inside] = [b, a, next];
    }
  }

  /** Outline of a contact, on the skin at rest as its arrow is. */
  #outline({ patch, x, y, position, outline }, tint) {
    if (!outline || outline.length < 2) return;
    const frame = this.#tangents(patch, x, y);
    if (!frame) return;
    const [right, up] = frame;
    const place = (t, out) => {
      const point = outline[Math.round(t * outline.length) % outline.length];
      const d = [point[0] - position[0], point[1] - position[1], point[2] - position[2]];
      out[0] = x + d[0] * right[0] + d[1] * right[1] + d[2] * right[2];
      out[1] = y + d[0] * up[0] + d[1] * up[1] + d[2] * up[2];
    };
    this.#path(outline.length, patch, tint, { width: 2, rest: true }, place);
  }

  /** Directions in space of the plane's two axes, at a place. */
  #tangents(patch, x, y) {
    const step = 1e-4;
    const axes = [];
    for (const [dx, dy] of [[step, 0], [0, step]]) {
      const a = { position: [0, 0, 0], normal: [0, 0, 1] };
      const b = { position: [0, 0, 0], normal: [0, 0, 1] };
      this.patches.at(patch, x - dx, y - dy, a, true);
      this.patches.at(patch, x + dx, y + dy, b, true);
      const along = b.position.map((value, i) => value - a.position[i]);
      const long = Math.hypot(...along);
      if (!(long > 0)) return null;
      axes.push(along.map((value) => value / long));
    }
    return axes;
  }
}

/**
 * What is drawn on the skin besides itself: contacts that were found, presses that are known, the
 * window that is looked at, and the tool under the pointer.
 */

import * as THREE from "three";
import { fixed, forceWords, orElse } from "../format.js";
import { matched, unfound } from "../truth_match.js";
import { Arrows, arrowLength } from "./arrows.js";
import { Corner } from "./corner.js";
import { placeEllipse } from "./ellipse.js";
import { Labels } from "./labels.js";
import { leaderEnd } from "./layout.js";
import { Lines } from "./lines.js";

const AROUND = 32; // segments of a ring
const CORNERS = 8; // of the box around a contact
const ROOM_PX = 3; // around it
const THIN = 24; // of the ellipse where a contact may be
const EDGE = 24; // segments of a side of the focus window
const DASHES = 14;
const NARROW = 480; // px of a picture in which labels are brief
const MANY = 5; // contacts, from more of which on they are
const UNKNOWN = 0.3; // of the skin's size, from which on an ellipse says nothing of a place
const EDGE_PX = 6; // from the picture's border, within which no arrow begins

const colour = (text) => new THREE.Color(text);

/** Unit vector against a force onto the skin: along its normal, or leaning by what pushes along it. */
function against(normal, force, shear) {
  if (!shear || !(force > 0)) return normal;
  const whole = normal.map((value, axis) => force * value - shear.vector[axis]);
  const size = Math.hypot(...whole);
  return whole.map((value) => value / size);
}

export class Marks {
  /** @param {import("./patches.js").Patches} patches */
  constructor(patches) {
    this.patches = patches;
    this.lines = new Lines();
    this.arrows = new Arrows();
    this.labels = new Labels();
    this.group = new THREE.Group();
    this.above = new Lines(256, { above: true });
    this.corner = new Corner();
    this.group.add(this.lines.mesh, this.arrows.mesh, this.above.mesh, this.labels.group);
    this.contacts = [];
    this.unit = "N"; // of their forces
    this.truth = [];
    this.shapes = []; // images of contacts
    this.waiting = []; // presses that are asked for: {id, position, why}
    this.focus = null;
    this.tool = null;
    this.size = 0.1;
    this.labelled = true;
    this.place = { position: [0, 0, 0], normal: [0, 0, 1] };
    this.from = { position: [0, 0, 0], normal: [0, 0, 1] };
    this.wanted = [];
    this.kept = [];
    /** @type {import("./layout.js").Box[]} what stands over the picture, px */
    this.covered = [];
    this.brief = false; // labels say the force alone
    this.seen = new THREE.Vector3();
    this.seenColour = new THREE.Color();
    this.tail = new THREE.Vector3();
  }

  setScreen(width, height, ratio) {
    this.lines.setScreen(width * ratio, height * ratio, ratio);
    this.above.setScreen(width * ratio, height * ratio, ratio);
    this.arrows.setScreen(width * ratio, height * ratio, ratio);
    this.labels.setScreen(width, height, ratio);
  }

  setTheme(theme) {
    this.theme = theme;
    this.arrows.setCasing(theme.background);
    this.lines.setCasing(theme.casing);
    this.above.setCasing(theme.background);
    this.corner.setTheme(theme);
    const { contact, truth, muted, onSkin } = theme;
    this.onSkin = Object.fromEntries(
      Object.entries(onSkin).map(([name, text]) => [name, colour(text)]),
    );
    this.tint = { contact: colour(contact), truth: colour(truth), old: colour(muted) };
  }

  /**
   * Writes all marks for this picture.
   *
   * @param {import("./camera.js").OrbitCamera} view
   */
  draw(view) {
    for (const each of [this.lines, this.arrows, this.above]) each.clear();
    this.wanted.length = 0;
    this.kept.length = 0;
    this.kept.push(...this.covered);
    this.brief = view.width < NARROW || this.contacts.length > MANY;
    this.corner.draw(view, this.above, this.wanted, this.patches.ruling, this.patches.setView(view.out()));
    const rows = matched(this.contacts, this.truth);
    for (const press of this.truth) this.#truth(press, view);
    for (const image of this.shapes) this.#shape(image);
    for (const press of this.waiting) this.#waits(press, view);
    for (const row of rows) this.#contact(row, view);
    for (const press of unfound(rows, this.truth)) this.#missed(press, view);
    for (const [i, patch] of this.patches.all) this.#name(i, patch, view);
    if (this.focus) this.#window(this.focus);
    if (this.tool) this.#ring(this.tool, this.tool.radius, this.onSkin.tool, { opacity: 0.9 });
    this.lines.finish();
    this.arrows.finish();
    const shown = this.labelled ? this.wanted : this.wanted.filter(({ plain }) => plain);
    this.labels.set(shown, this.kept, this.theme);
    for (const label of this.labels.placed) this.#leader(label, view);
    this.above.finish();
  }

  #contact({ contact, truth, error_m }, view) {
    const { old } = contact;
    if (!this.shapes.length) this.#outline(contact, old ? this.tint.old : this.onSkin.contact);
    const reach = old ? 0 : this.#uncertainty(contact);
    const place = this.#rest(contact);
    const tail = this.#arrow(place, contact, old ? this.tint.old : this.tint.contact, false, view);
    this.#keep(contact, Math.max(reach, Math.sqrt((contact.area || 1e-5) / Math.PI)), view);
    this.#keepArrow(place.position, tail, view);
    const maybe = contact.maybe ? ` · ${orElse(contact.maybe)}?` : "";
    this.#label(`c${contact.key}`, tail, view, {
      title: `${forceWords(contact)} ${this.unit}${maybe}`,
      aside: truth && view.width >= NARROW ? `truth ${fixed(truth.force, 2)}` : "",
      second: this.theme.truth,
      detail: this.brief ? "" : this.#detail(contact, truth && !old ? error_m : NaN),
      accent: old ? this.theme.muted : this.theme.contact,
      side: 1,
    });
  }

  /** Below a contact's force: its track, place and force along the skin, and how far from the truth it is. */
  #detail({ track, old, seen, shear, ...place }, off) {
    if (old) return `#${track}  ${seen ?? "not of now"}`;
    const words = [`#${track}  ${this.#where(place)}`, shear && `${fixed(shear.size, 2)} ${this.unit} along`, Number.isFinite(off) && `${fixed(1e3 * off)} off`];
    return words.filter(Boolean).join(", ");
  }

  #truth(press, view) {
    const place = this.#rest(press);
    const tail = this.#arrow(place, press, this.tint.truth, true, view);
    const radius = press.contact_radius || press.radius || 0.002;
    this.#keep(press, radius, view);
    this.#keepArrow(place.position, tail, view);
    if (press.border) this.#polygon(press, press.border, [press.x, press.y, 0], this.onSkin.truth, { dashed: true });
    else this.#ring(press, radius, this.onSkin.truth, { dashed: true, rest: true });
  }

  /** The outline of what touches, from many readings of it. */
  #shape({ patch, pose, outline }) {
    for (const line of outline) this.#polygon({ patch }, line, pose, this.onSkin.contact, { width: 2.6 });
  }

  /** A closed line on the skin at rest, of a body at a place and turn in the patch's plane. */
  #polygon({ patch }, line, [x, y, turn], tint, look) {
    if (line.length < 2) return;
    const [c, s, last] = [Math.cos(turn), Math.sin(turn), line.length - 1];
    const count = last * (look.dashed ? Math.ceil((2 * EDGE) / last) : 1); // a dashed one has few corners
    this.#path(count, patch, tint, { width: 2, rest: true, ...look }, (t, out) => {
      const k = Math.min(Math.floor(t * last), last - 1);
      const [u, v] = [0, 1].map((axis) => line[k][axis] + (t * last - k) * (line[k + 1][axis] - line[k][axis]));
      out[0] = x + c * u - s * v;
      out[1] = y + s * u + c * v;
    });
  }

  /** A press that was not found, or not yet. */
  #missed(press, view) {
    const place = this.#rest(press);
    this.#label(`t${press.id}`, this.#tail(place, press, view), view, {
      title: `truth ${fixed(press.force, 2)} N`,
      detail: this.brief ? "not found" : `${this.#where(press)}  not found`,
      accent: this.theme.truth,
      side: -1,
    });
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

  /** The name of a patch at its lower border; where it does not answer, that too. */
  #name(i, { answer, waiting, surface, about }, view) {
    if (!surface) return;
    const silent = answer === "missing" && !waiting;
    const { centre } = surface.nodes.sphere;
    if (silent) {
      this.#label(`m${i}`, this.seen.set(...centre).clone(), view, {
        title: about.name,
        detail: "no reading",
        accent: this.theme.muted,
        side: 0,
      });
      return;
    }
    if (!surface.faces(view.camera.position)) return;
    const [anchorX, anchorY] = this.patches.foot(i, (at) => this.#pixel(this.seen.set(...at), view));
    const look = { plain: this.theme.muted, faint: true, side: 2, spare: true };
    if (this.patches.all.size === 1) return; // the header has it
    this.wanted.push({ key: `n${i}`, title: about.name, ...look, anchorX, anchorY: anchorY - 8 });
  }

  #label(key, at, view, label) {
    const [x, y] = this.#pixel(at, view);
    if (Math.abs(this.seen.z) > 1) return;
    this.wanted.push({ key, ...label, brief: this.brief, anchorX: x, anchorY: y });
  }

  /** From a label to what it names. */
  #leader(label, view) {
    if (label.hidden || !label.accent) return;
    const [x, y] = leaderEnd(label);
    if (Math.hypot(x - label.anchorX, y - label.anchorY) < 4) return;
    const ends = [view.at(label.anchorX, label.anchorY), view.at(x, y)].map((at) => at.toArray());
    this.above.add(...ends, this.seenColour.set(label.accent), { width: 1.5 });
  }

  /** A place in words; the patch is named where there are several. */
  #where({ patch, x, y }) {
    const { all } = this.patches;
    const name = all.size > 1 ? `${all.get(patch)?.about.name ?? patch}  ` : "";
    return `${name}x ${fixed(1e3 * x)}  y ${fixed(1e3 * y)} mm`;
  }

  /** Labels are not to hide what is within a radius of a contact, nor its arrow. */
  #keep({ patch, x, y, position }, radius, view) {
    const out = { position: [...position], normal: [0, 0, 1] };
    const seen = [];
    for (let turn = 0; turn < CORNERS; turn += 1) {
      const angle = (turn * 2 * Math.PI) / CORNERS;
      this.patches.at(patch, x + radius * Math.cos(angle), y + radius * Math.sin(angle), out, true);
      seen.push(this.#pixel(this.seen.set(...out.position), view));
    }
    const [left, top] = [0, 1].map((axis) => Math.min(...seen.map((at) => at[axis])) - ROOM_PX);
    const [right, low] = [0, 1].map((axis) => Math.max(...seen.map((at) => at[axis])) + ROOM_PX);
    this.kept.push({ x: left, y: top, width: right - left, height: low - top });
  }

  #keepArrow(tip, tail, view) {
    const [ax, ay] = this.#pixel(this.seen.set(...tip), view);
    const [bx, by] = this.#pixel(tail, view);
    for (let part = 0; part < 4; part += 1) {
      const [x, y] = [ax + ((part + 0.5) / 4) * (bx - ax), ay + ((part + 0.5) / 4) * (by - ay)];
      const [wide, tall] = [Math.max(14, Math.abs(bx - ax) / 4), Math.max(10, Math.abs(by - ay) / 4)];
      this.kept.push({ x: x - wide / 2, y: y - tall / 2, width: wide, height: tall, light: true });
    }
  }

  /** CSS px of a place; its depth stays in `seen.z`. */
  #pixel(at, view) {
    const { seen } = this;
    seen.copy(at).project(view.camera);
    return [(seen.x + 1) * 0.5 * view.width, (1 - seen.y) * 0.5 * view.height];
  }

  /** @returns {THREE.Vector3} where the arrow begins */
  #arrow(place, press, tint, hollow, view) {
    const tail = this.#tail(place, press, view);
    this.arrows.add(tail.toArray(), place.position, tint, hollow);
    return tail;
  }

  /** Where an arrow begins: inside the picture, if its tip is. */
  #tail({ position, normal }, { patch, force, shear }, view) {
    // On a small patch of a large skin, an arrow of the patch's own size
    const side = this.patches.all.get(patch)?.about.side || this.size;
    const long = arrowLength(Math.hypot(force, shear?.size ?? 0), Math.min(this.size, 1.8 * side));
    const { tail } = this;
    const back = against(normal, force, shear);
    for (const part of [1, 0.85, 0.7, 0.55, 0.4]) {
      tail.set(...position).addScaledVector(this.seen.set(...back), part * long);
      const [x, y] = this.#pixel(tail, view);
      if (x > EDGE_PX && y > EDGE_PX && x < view.width - EDGE_PX && y < view.height - EDGE_PX) break;
    }
    return tail;
  }

  /**
   * The ellipse that holds the place of a contact nine times in ten.
   * @returns {number} how far it reaches, m; 0 where none is drawn
   */
  #uncertainty({ patch, x, y, place_cov }) {
    const ellipse = place_cov && placeEllipse(place_cov);
    if (!ellipse || !(ellipse.a > 0) || ellipse.a > UNKNOWN * this.size) return 0;
    const { a, b, angle } = ellipse;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const look = { width: 1.2, opacity: 0.85, rest: true };
    this.#path(THIN, patch, this.onSkin.contact, look, (t, out) => {
      const [u, v] = [a * Math.cos(2 * Math.PI * t), b * Math.sin(2 * Math.PI * t)];
      out[0] = x + c * u - s * v;
      out[1] = y + s * u + c * v;
    });
    return Math.max(a, b);
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

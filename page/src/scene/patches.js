/**
 * All patches of the skin: their surfaces by grid, their taxels, and how each is shown now.
 */

import * as THREE from "three";
import { borderOf } from "./border.js";
import { Dots } from "./dots.js";
import { roundLength } from "./ruler.js";
import { Surface } from "./surface.js";

class Patch {
  constructor(about) {
    this.about = about;
    /** @type {Map<number, Surface>} by rung */
    this.surfaces = new Map();
    /** @type {Surface|null} */
    this.surface = null;
    this.dots = null;
    /** @type {import("./border.js").Border|null} */
    this.border = null;
    this.full = 1;
    this.answer = "missing";
    this.waiting = true;
  }
}

/** Quantities that the taxels show, on a skin without colours of its own. */
const PLAIN = new Set(["taxels"]);

export class Patches {
  /**
   * @param {THREE.Texture} table colours of the map
   * @param {number} finest vertices along a side of a patch
   */
  constructor(table, finest) {
    this.table = table;
    this.finest = finest;
    this.group = new THREE.Group();
    /** @type {Map<number, Patch>} */
    this.all = new Map();
    this.exaggeration = 3;
    this.quantity = "pressure";
    this.taxels = true;
    this.bar = [0, 1];
    this.theme = null;
    this.perMetre = 1;
    /** Side of the squares that are ruled on the skin, m. */
    this.ruling = 0.005;
  }

  /** @param {{i: number}[]} patches of a hello: the scene begins anew */
  reset(patches) {
    for (const patch of this.all.values()) {
      for (const surface of patch.surfaces.values()) surface.dispose();
      patch.dots?.dispose();
    }
    this.group.clear();
    this.all.clear();
    this.ruling = roundLength(Math.max(0.01, ...patches.map(({ side }) => side || 0)) / 9);
    for (const about of patches) this.all.set(about.i, new Patch(about));
  }

  setGeometry(head, arrays) {
    const patch = this.all.get(head.patch);
    if (!patch) return;
    const old = patch.surfaces.get(head.rung);
    if (arrays.taxels?.length && arrays.taxel_normals) this.#addDots(patch, arrays);
    patch.border ??= borderOf(arrays, patch.about.pitch);
    const { table, finest } = this;
    const look = { table, finest, patches: this.all.size, border: patch.border, ruling: this.ruling };
    const surface = new Surface(head, arrays, look);
    patch.surfaces.set(head.rung, surface);
    if (old) {
      this.group.remove(old.mesh);
      old.dispose();
    }
    if (patch.surface === null || patch.surface === old) patch.surface = surface;
    this.group.add(surface.mesh);
    this.#show(patch);
  }

  #addDots(patch, arrays) {
    if (patch.dots) {
      this.group.remove(patch.dots.mesh);
      patch.dots.dispose();
    }
    const pitch = patch.about.pitch || 0.005;
    patch.dots = new Dots(arrays.taxels, arrays.taxel_normals, pitch, this.table);
    this.group.add(patch.dots.mesh);
  }

  /**
   * @param {object} entry of an update's `patches`
   * @param {ArrayLike<number>[]} arrays of the update, in order
   * @param {number|null} full what the strongest reading of a taxel stands for, where it is told
   */
  update(entry, arrays, full = null) {
    const patch = this.all.get(entry.i);
    if (!patch) return;
    patch.answer = entry.answer;
    patch.waiting = false;
    const surface = patch.surfaces.get(entry.rung) ?? patch.surface;
    const known = patch.surfaces.has(entry.rung) || entry.height < 0;
    if (surface && known) {
      patch.surface = surface;
      const height = fitting(arrays[entry.height], surface.nodes.given);
      const colour = fitting(arrays[entry.colour], surface.nodes.given);
      surface.setExaggeration(this.#times);
      surface.setHeight(height, entry.height_scale, entry.height_zero ?? 0);
      surface.setColour(colour, colour ? entry.colour_lo : 0, colour ? entry.colour_hi : 0);
    }
    const readings = arrays[entry.taxels];
    if (readings && patch.dots) patch.dots.setReadings(readings, arrays[entry.repaired]);
    patch.full = entry.taxels_full ?? full ?? patch.full;
    this.#show(patch);
  }

  #show(patch) {
    const missing = patch.answer === "missing" && !patch.waiting;
    for (const surface of patch.surfaces.values()) {
      surface.mesh.visible = surface === patch.surface;
      const { uniforms } = surface.material;
      uniforms.missing.value = missing ? 1 : 0;
      uniforms.plain.value = PLAIN.has(this.quantity) ? 1 : 0;
      uniforms.bar.value.set(...this.bar);
      if (this.theme) {
        uniforms.grey.value.set(missing ? this.theme.missing : this.theme.plain);
        uniforms.rim.value.set(this.theme.rim);
        uniforms.ink.value.set(this.theme.line);
      }
    }
    if (!patch.dots) return;
    const large = this.quantity === "taxels";
    patch.dots.mesh.visible = !missing;
    patch.dots.show(this.taxels || large, large);
    patch.dots.setColours(patch.full, this.bar);
    if (this.theme) patch.dots.setTheme(this.theme);
    patch.dots.setSize(this.perMetre);
    if (patch.surface) patch.dots.follow(patch.surface);
  }

  /** How much deeper than real the skin sinks; not at all under its raw readings. */
  get #times() {
    return PLAIN.has(this.quantity) ? 0 : this.exaggeration;
  }

  /** Shows all again, after a setting changed. */
  refresh() {
    for (const patch of this.all.values()) {
      patch.surface?.setExaggeration(this.#times);
      this.#show(patch);
    }
  }

  /**
   * Draws dents as deep as they can be seen into.
   *
   * @param {THREE.Vector3} out direction to the camera
   * @returns {number} how much deeper than real the dents are drawn that are least so
   */
  setView(out) {
    let least = this.exaggeration;
    for (const { surface, dots } of this.all.values()) {
      if (!surface) continue;
      surface.setView(out);
      dots?.setDepth(surface.scale);
      if (!surface.nodes.flat) least = Math.min(least, surface.times);
    }
    return least;
  }

  setSize(perMetre) {
    this.perMetre = perMetre;
    for (const { dots } of this.all.values()) dots?.setSize(perMetre);
  }

  /**
   * A place of a patch as it is drawn now.
   *
   * @param {number} i of the patch
   * @param {number} x in its plane, m
   * @param {number} y
   * @param {{position: number[], normal: number[]}} out
   * @param {boolean} [rest] as it is without any press
   * @returns {boolean} whether it is on the skin
   */
  at(i, x, y, out, rest = false) {
    const surface = this.all.get(i)?.surface;
    if (!surface) return false;
    return surface.nodes.at(x, y, rest ? 0 : surface.scale, out);
  }

  /**
   * Where a ray first meets the skin.
   *
   * @param {ArrayLike<number>} origin
   * @param {ArrayLike<number>} direction
   * @param {boolean} [rest] as it is without any press
   * @returns {{patch: number, x: number, y: number, position: number[]}|null} place at rest
   */
  hit(origin, direction, rest = false) {
    let best = null;
    let patch = -1;
    for (const [i, { surface }] of this.all) {
      if (!surface) continue;
      const found = surface.nodes.hit(origin, direction, rest ? 0 : surface.scale);
      if (!found || (best && found.distance >= best.distance)) continue;
      best = found;
      patch = i;
    }
    if (!best) return null;
    const out = { position: [0, 0, 0], normal: [0, 0, 1] };
    this.at(patch, best.x, best.y, out, true);
    return { patch, x: best.x, y: best.y, position: out.position };
  }

  /**
   * Where the name of a patch stands: the place of its border that is lowest in the picture.
   *
   * @param {number} i
   * @param {(at: ArrayLike<number>) => [number, number]} pixel of a place
   * @returns {[number, number]} px
   */
  foot(i, pixel) {
    const seen = this.all.get(i).surface.rim.map(pixel);
    const lowest = Math.max(...seen.map(([, y]) => y));
    const low = seen.filter(([, y]) => y > lowest - 5); // a level border: its middle
    return [low.reduce((sum, [x]) => sum + x, 0) / low.length, lowest];
  }

  /** What the home view has to show: the drawn skin of all patches, and its mean normal. */
  subject(headroom) {
    const points = [];
    const normal = new THREE.Vector3();
    let count = 0;
    for (const { surface } of this.all.values()) {
      if (!surface) continue;
      const { position, outward, cover } = surface.geometry.attributes;
      const step = Math.max(1, Math.floor(cover.count / 500));
      for (let k = 0; k < cover.count; k += 1) {
        // All along the border, where the corners are, and some inside
        const inside = cover.array[k];
        if (inside < 0.4 || (inside > 0.9 && k % step !== 0)) continue;
        const at = new THREE.Vector3().fromBufferAttribute(position, k);
        const out = new THREE.Vector3().fromBufferAttribute(outward, k);
        points.push(at, at.clone().addScaledVector(out, headroom));
        normal.add(out);
        count += 1;
      }
    }
    if (count > 0) normal.divideScalar(count);
    return { points, normal };
  }
}

function fitting(array, count) {
  return array && array.length === count ? array : null;
}

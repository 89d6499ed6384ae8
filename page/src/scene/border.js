/**
 * Where the drawn skin of a patch ends: a border around its taxels, the same on every grid.
 */

import { convexHull, depthInside } from "./hull.js";

/** Of the pitch: how far the skin goes on beyond the centres of its outermost taxels. */
const MARGIN = 0.42;

export class Border {
  /**
   * @param {Float64Array} hull of the taxels, in the patch's plane
   * @param {number} margin m beyond it
   */
  constructor(hull, margin) {
    this.hull = hull;
    this.margin = margin;
  }

  /** @param {ArrayLike<number>} plane of a grid @returns {number} nodes that it needs beyond it */
  pad(plane) {
    const pitch = Math.abs(plane[2] - plane[0]) || this.margin;
    return Math.min(6, Math.ceil(this.margin / pitch) + 1);
  }

  /**
   * Cuts off what lies beyond the border.
   *
   * @param {Float32Array} cover of vertices, inside above 0.5; changed
   * @param {ArrayLike<number>} plane of the vertices
   * @param {number} width over which it falls by one, m; several cells, so that a cell between two
   *   of them sees a straight slope
   */
  trim(cover, plane, width) {
    for (let k = 0; k < cover.length; k += 1) {
      const depth = depthInside(this.hull, plane[2 * k], plane[2 * k + 1]) + this.margin;
      cover[k] = Math.min(cover[k], 0.5 + depth / width);
    }
  }
}

/**
 * @param {{taxels?: ArrayLike<number>, positions: ArrayLike<number>, plane: ArrayLike<number>}}
 *   arrays of the first geometry of a patch
 * @param {number} pitch between taxels, m
 * @returns {Border|null} null where no taxels came
 */
export function borderOf(arrays, pitch) {
  if (!arrays.taxels?.length || !(pitch > 0)) return null;
  const points = [];
  for (let i = 0; i < arrays.taxels.length; i += 3) points.push(...inPlane(arrays, i));
  return new Border(convexHull(points), MARGIN * pitch);
}

/** A taxel's place in the patch's plane, from the node next to it. */
function inPlane({ taxels, positions, plane }, at) {
  let best = 0;
  let least = Infinity;
  const apart = (k, a) => taxels[at + a] - positions[3 * k + a];
  for (let k = 0; k < plane.length / 2; k += 1) {
    const square = apart(k, 0) ** 2 + apart(k, 1) ** 2 + apart(k, 2) ** 2;
    if (square < least) [least, best] = [square, k];
  }
  return [0, 1].map((axis) => plane[2 * best + axis] + along(axis));

  /** How far the taxel is from that node along one of the plane's axes. */
  function along(axis) {
    const next = neighbour(plane, best, axis);
    if (next < 0) return 0;
    const step = plane[2 * next + axis] - plane[2 * best + axis];
    let sum = 0;
    for (let a = 0; a < 3; a += 1) {
      sum += (apart(best, a) * (positions[3 * next + a] - positions[3 * best + a])) / step;
    }
    return sum;
  }
}

/** A node next to one, along one axis of the plane. */
function neighbour(plane, k, axis) {
  const count = plane.length / 2;
  let columns = 1;
  while (columns < count && plane[2 * columns + 1] === plane[1]) columns += 1;
  const step = axis === 0 ? 1 : columns;
  const row = Math.floor(k / columns);
  for (const other of [k + step, k - step]) {
    if (other < 0 || other >= count) continue;
    if (axis === 0 && Math.floor(other / columns) !== row) continue;
    return other;
  }
  return -1;
}

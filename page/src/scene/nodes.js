/**
 * One patch on one grid, as the server sent it: places between nodes, heights, and where a ray
 * meets it. Arithmetic only.
 */

import { nearestCovered } from "./grid.js";

export class Nodes {
  /**
   * @param {{patch: number, rung: number, rows: number, columns: number}} head
   * @param {{positions: ArrayLike<number>, normals: ArrayLike<number>, plane: ArrayLike<number>,
   *   covered: ArrayLike<number>}} arrays copied: the message they came in can go
   * @param {number} pad nodes added on each side, so that the drawn skin can end beyond the grid
   */
  constructor(head, arrays, pad = 0) {
    const { rows, columns } = head;
    this.patch = head.patch;
    this.rung = head.rung;
    /** How many nodes the server sends values for. */
    this.given = rows * columns;
    this.rows = rows + 2 * pad;
    this.columns = columns + 2 * pad;
    this.count = this.rows * this.columns;
    this.positions = extended(arrays.positions, 3, rows, columns, pad);
    this.normals = unit(extended(arrays.normals, 3, rows, columns, pad));
    this.plane = extended(arrays.plane, 2, rows, columns, pad);
    this.covered = new Uint8Array(this.count);
    for (let k = 0; k < this.given; k += 1) {
      const row = Math.floor(k / columns) + pad;
      this.covered[row * this.columns + (k % columns) + pad] = arrays.covered[k] ? 1 : 0;
    }
    this.source = sources(this, rows, columns, pad);
    this.origin = [this.plane[0], this.plane[1]];
    this.pitch = pitchOf(this);
    /** Inwards, in the unit of the server; below zero where the skin swells. */
    this.height = new Float32Array(this.count);
    this.flat = true;
    this.sunk = new Float32Array(3 * this.count);
    this.sphere = boundingSphere(this.positions, this.covered);
  }

  /**
   * @param {ArrayLike<number>|null} values u16 per node, inwards; null: flat
   * @param {number} zero the value of skin at rest
   */
  setHeight(values, zero = 0) {
    if (values) for (let k = 0; k < this.count; k += 1) this.height[k] = values[this.source[k]] - zero;
    else if (!this.flat) this.height.fill(0);
    this.flat = !values;
  }

  /**
   * A place of the patch's plane: where it is in space.
   *
   * @param {number} x in m
   * @param {number} y in m
   * @param {number} scale m inwards per unit of height; 0: the skin at rest
   * @param {{position: number[], normal: number[]}} out
   * @returns {boolean} whether the place is on the patch
   */
  at(x, y, scale, out) {
    const column = (x - this.origin[0]) / this.pitch;
    const row = (y - this.origin[1]) / this.pitch;
    const u = clamp(column, 0, this.columns - 1);
    const v = clamp(row, 0, this.rows - 1);
    const c = Math.min(Math.floor(u), Math.max(0, this.columns - 2));
    const r = Math.min(Math.floor(v), Math.max(0, this.rows - 2));
    const k = r * this.columns + c;
    const right = this.columns > 1 ? 1 : 0;
    const down = this.rows > 1 ? this.columns : 0;
    const corner = [k, k + right, k + down, k + down + right];
    const [s, t] = [u - c, v - r];
    const weight = [(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t];
    const { position, normal } = out;
    position.fill(0);
    normal.fill(0);
    let height = 0;
    for (let i = 0; i < 4; i += 1) {
      height += weight[i] * this.height[corner[i]];
      for (let a = 0; a < 3; a += 1) {
        position[a] += weight[i] * this.positions[3 * corner[i] + a];
        normal[a] += weight[i] * this.normals[3 * corner[i] + a];
      }
    }
    const long = Math.hypot(normal[0], normal[1], normal[2]) || 1;
    for (let a = 0; a < 3; a += 1) {
      normal[a] /= long;
      position[a] -= normal[a] * height * scale;
    }
    if (Math.abs(u - column) > 0.5 || Math.abs(v - row) > 0.5) return false;
    return corner.some((node) => this.covered[node] === 1);
  }

  /**
   * Where a ray first meets the patch from outside.
   *
   * @param {ArrayLike<number>} origin
   * @param {ArrayLike<number>} direction of length 1
   * @param {number} scale m inwards per unit of height; 0: the skin at rest
   * @returns {{distance: number, x: number, y: number}|null} place in the patch's plane
   */
  hit(origin, direction, scale) {
    const reach = 65535 * scale;
    if (!meetsSphere(origin, direction, this.sphere, this.flat ? 0 : reach)) return null;
    const points = this.#displaced(scale);
    const best = { distance: Infinity, x: 0, y: 0 };
    for (let r = 0; r + 1 < this.rows; r += 1) {
      for (let c = 0; c + 1 < this.columns; c += 1) {
        const k = r * this.columns + c;
        const d = k + this.columns;
        if (!(this.covered[k] || this.covered[k + 1] || this.covered[d] || this.covered[d + 1])) {
          continue;
        }
        this.#triangle(points, origin, direction, k, k + 1, d + 1, best);
        this.#triangle(points, origin, direction, k, d + 1, d, best);
      }
    }
    return best.distance < Infinity ? best : null;
  }

  #displaced(scale) {
    if (this.flat || scale === 0) return this.positions;
    const { sunk, positions, normals, height } = this;
    for (let k = 0; k < this.count; k += 1) {
      const depth = height[k] * scale;
      for (let a = 3 * k; a < 3 * k + 3; a += 1) sunk[a] = positions[a] - normals[a] * depth;
    }
    return sunk;
  }

  /** Möller and Trumbore 1997; only triangles seen from outside count. */
  #triangle(p, o, d, i, j, k, best) {
    const ax = p[3 * i], ay = p[3 * i + 1], az = p[3 * i + 2];
    const ux = p[3 * j] - ax, uy = p[3 * j + 1] - ay, uz = p[3 * j + 2] - az;
    const vx = p[3 * k] - ax, vy = p[3 * k + 1] - ay, vz = p[3 * k + 2] - az;
    const px = d[1] * vz - d[2] * vy, py = d[2] * vx - d[0] * vz, pz = d[0] * vy - d[1] * vx;
    const det = ux * px + uy * py + uz * pz;
    if (Math.abs(det) < 1e-18) return;
    const tx = o[0] - ax, ty = o[1] - ay, tz = o[2] - az;
    const s = (tx * px + ty * py + tz * pz) / det;
    if (s < 0 || s > 1) return;
    const qx = ty * uz - tz * uy, qy = tz * ux - tx * uz, qz = tx * uy - ty * ux;
    const t = (d[0] * qx + d[1] * qy + d[2] * qz) / det;
    if (t < 0 || s + t > 1) return;
    const distance = (vx * qx + vy * qy + vz * qz) / det;
    if (distance <= 0 || distance >= best.distance) return;
    const n = this.normals;
    if (d[0] * n[3 * i] + d[1] * n[3 * i + 1] + d[2] * n[3 * i + 2] >= 0) return;
    const plane = this.plane;
    best.distance = distance;
    best.x = plane[2 * i] * (1 - s - t) + plane[2 * j] * s + plane[2 * k] * t;
    best.y = plane[2 * i + 1] * (1 - s - t) + plane[2 * j + 1] * s + plane[2 * k + 1] * t;
  }
}

function clamp(value, low, high) {
  return value < low ? low : value > high ? high : value;
}

function pitchOf({ plane, columns, rows }) {
  if (columns > 1) return plane[2] - plane[0];
  return rows > 1 ? plane[2 * columns + 1] - plane[1] : 1;
}

/** A grid with `pad` more nodes on each side, which go on straight. */
function extended(values, stride, rows, columns, pad) {
  const wide = columns + 2 * pad;
  const out = new Float32Array(stride * wide * (rows + 2 * pad));
  const read = (r, c, a) => values[(r * columns + c) * stride + a];
  const along = (r, c, a) => beyond((i) => read(r, i, a), c, columns);
  for (let r = -pad; r < rows + pad; r += 1) {
    for (let c = -pad; c < columns + pad; c += 1) {
      const at = ((r + pad) * wide + c + pad) * stride;
      for (let a = 0; a < stride; a += 1) out[at + a] = beyond((i) => along(i, c, a), r, rows);
    }
  }
  return out;
}

function beyond(read, i, count) {
  if (i >= 0 && i < count) return read(i);
  const end = i < 0 ? 0 : count - 1;
  const before = i < 0 ? Math.min(1, count - 1) : Math.max(0, count - 2);
  const value = read(end);
  return value + Math.abs(i - end) * (value - read(before));
}

function unit(normals) {
  for (let k = 0; k < normals.length; k += 3) {
    const long = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
    for (let a = k; a < k + 3; a += 1) normals[a] /= long;
  }
  return normals;
}

/** For each node, the one of the server's whose value it shows. */
function sources(nodes, rows, columns, pad) {
  const wide = nodes.columns;
  const limit = (value, count) => Math.min(count - 1, Math.max(0, value - pad));
  return nearestCovered(nodes.rows, wide, nodes.covered, pad + 3).map(
    (k) => limit(Math.floor(k / wide), rows) * columns + limit(k % wide, columns),
  );
}

function boundingSphere(positions, covered) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < covered.length; k += 1) {
    if (!covered[k]) continue;
    for (let a = 0; a < 3; a += 1) {
      low[a] = Math.min(low[a], positions[3 * k + a]);
      high[a] = Math.max(high[a], positions[3 * k + a]);
    }
  }
  if (low[0] > high[0]) return { centre: [0, 0, 0], radius: 0 };
  const centre = low.map((value, a) => (value + high[a]) / 2);
  return { centre, radius: 0.55 * Math.hypot(...high.map((value, a) => value - low[a])) };
}

function meetsSphere(origin, direction, { centre, radius }, more) {
  let along = 0;
  let square = 0;
  for (let a = 0; a < 3; a += 1) {
    const to = centre[a] - origin[a];
    along += to * direction[a];
    square += to * to;
  }
  const reach = radius * 1.1 + more;
  return square - along * along <= reach * reach;
}

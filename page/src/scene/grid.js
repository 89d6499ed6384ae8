/**
 * Nodes of a patch and the finer mesh that is drawn between them: arithmetic only, no WebGL.
 *
 * The server answers on a grid of nodes. The page draws `factor` times
 * `factor` squares per cell and interpolates between the nodes without ever leaving the range of
 * the two next to a place, so that smoothness is all that is added.
 */

/** Vertices of all patches together up to which a finer mesh is worth its time. */
const BUDGET = 36000;
/** Vertices along a side beyond which nothing is gained. */
export const FINEST = 80;

/**
 * How many times finer the drawn mesh is than the nodes.
 *
 * @param {number} rows
 * @param {number} columns
 * @param {number} patches that share the picture
 * @param {number} finest vertices along a side
 * @returns {number} 1 or more
 */
export function refinement(rows, columns, patches, finest = FINEST) {
  const affordable = Math.floor(Math.sqrt(BUDGET / (patches * rows * columns)));
  const useful = Math.ceil(finest / Math.max(rows, columns));
  return Math.max(1, Math.min(affordable, useful, 8));
}

/**
 * For each node the one whose value it takes: itself where covered, else a covered neighbour.
 *
 * The mesh ends half a cell beyond the covered nodes; without this the border would show a mixture
 * with nodes where nothing is measured.
 *
 * @param {number} rows
 * @param {number} columns
 * @param {Uint8Array} covered
 * @param {number} reach how many nodes beyond the covered ones
 * @returns {Uint32Array}
 */
export function nearestCovered(rows, columns, covered, reach = 3) {
  const source = new Uint32Array(rows * columns).map((_, k) => k);
  let known = Uint8Array.from(covered);
  for (let step = 0; step < reach; step += 1) {
    const next = Uint8Array.from(known);
    for (let k = 0; k < source.length; k += 1) {
      if (known[k]) continue;
      const from = knownNeighbour(rows, columns, known, k);
      if (from < 0) continue;
      source[k] = source[from];
      next[k] = 1;
    }
    known = next;
  }
  return source;
}

const AROUND = [[0, 1], [0, -1], [1, 0], [-1, 0], [1, 1], [1, -1], [-1, 1], [-1, -1]];

function knownNeighbour(rows, columns, known, k) {
  const row = Math.floor(k / columns);
  const column = k % columns;
  for (const [down, right] of AROUND) {
    const r = row + down;
    const c = column + right;
    if (r < 0 || c < 0 || r >= rows || c >= columns) continue;
    if (known[r * columns + c]) return r * columns + c;
  }
  return -1;
}

/**
 * Weights of four neighbouring nodes for each place of a finer axis (Catmull and Rom 1974).
 *
 * @param {number} count nodes along the axis
 * @param {number} factor
 * @returns {{count: number, first: Int32Array, weights: Float32Array}} per place the second of its
 *   four nodes, and the weights
 */
export function axis(count, factor) {
  const fine = (count - 1) * factor + 1;
  const first = new Int32Array(fine);
  const weights = new Float32Array(4 * fine);
  for (let i = 0; i < fine; i += 1) {
    const node = Math.min(Math.floor(i / factor), Math.max(0, count - 2));
    const t = i / factor - node;
    first[i] = node;
    weights[4 * i] = 0.5 * t * (-1 + t * (2 - t));
    weights[4 * i + 1] = 0.5 * (2 + t * t * (-5 + 3 * t));
    weights[4 * i + 2] = 0.5 * t * (1 + t * (4 - 3 * t));
    weights[4 * i + 3] = 0.5 * t * t * (t - 1);
  }
  return { count: fine, first, weights };
}

/** Interpolates values of nodes onto the finer mesh; keeps its buffers. */
export class Refiner {
  /**
   * @param {number} rows
   * @param {number} columns
   * @param {number} factor
   */
  constructor(rows, columns, factor) {
    this.rows = rows;
    this.columns = columns;
    this.factor = factor;
    this.down = axis(rows, factor);
    this.right = axis(columns, factor);
    this.fineRows = this.down.count;
    this.fineColumns = this.right.count;
    this.count = this.fineRows * this.fineColumns;
    this.nodes = new Float32Array(rows * columns);
    this.between = new Float32Array(rows * this.fineColumns);
  }

  /**
   * @param {ArrayLike<number>} values of the nodes, row by row; `stride` of them per node
   * @param {Uint32Array|null} source node whose value each node takes
   * @param {Float32Array|Uint16Array} out of the finer mesh, same stride
   * @param {boolean} bounded whether to stay between the two nodes next to a place
   */
  apply(values, source, out, { stride = 1, offset = 0, bounded = true } = {}) {
    const { nodes } = this;
    for (let k = 0; k < nodes.length; k += 1) {
      nodes[k] = values[(source ? source[k] : k) * stride + offset];
    }
    this.#alongRows(bounded);
    this.#alongColumns(out, stride, offset, bounded);
    return out;
  }

  #alongRows(bounded) {
    const { nodes, between, rows, columns, fineColumns } = this;
    const { first, weights } = this.right;
    for (let r = 0; r < rows; r += 1) {
      const base = r * columns;
      for (let c = 0; c < fineColumns; c += 1) {
        const k = first[c];
        const before = base + (k > 0 ? k - 1 : 0);
        const next = base + Math.min(columns - 1, k + 1);
        const after = base + Math.min(columns - 1, k + 2);
        between[r * fineColumns + c] = mix(
          nodes[before], nodes[base + k], nodes[next], nodes[after], weights, 4 * c, bounded,
        );
      }
    }
  }

  #alongColumns(out, stride, offset, bounded) {
    const { between, rows, fineRows, fineColumns } = this;
    const { first, weights } = this.down;
    for (let r = 0; r < fineRows; r += 1) {
      const k = first[r];
      const before = (k > 0 ? k - 1 : 0) * fineColumns;
      const here = k * fineColumns;
      const next = Math.min(rows - 1, k + 1) * fineColumns;
      const after = Math.min(rows - 1, k + 2) * fineColumns;
      for (let c = 0; c < fineColumns; c += 1) {
        out[(r * fineColumns + c) * stride + offset] = mix(
          between[before + c], between[here + c], between[next + c], between[after + c],
          weights, 4 * r, bounded,
        );
      }
    }
  }
}

function mix(a, b, c, d, weights, w, bounded) {
  const value = weights[w] * a + weights[w + 1] * b + weights[w + 2] * c + weights[w + 3] * d;
  if (!bounded) return value;
  const low = b < c ? b : c;
  const high = b < c ? c : b;
  return value < low ? low : value > high ? high : value;
}

/**
 * How far inside the measured area each node is: above 0.5 inside, below it outside.
 *
 * It reaches further than the covered nodes, which end at the centres of taxels, and the stairs
 * along a slanted border are rounded off.
 *
 * @param {number} rows
 * @param {number} columns
 * @param {Uint8Array} covered
 * @param {number} reach nodes beyond the covered ones
 * @returns {Float32Array}
 */
export function coverage(rows, columns, covered, reach = 1) {
  let wider = Float32Array.from(covered);
  for (let step = 0; step < reach; step += 1) {
    wider = passed(rows, columns, wider, (a, b, c) => Math.max(a, b, c));
  }
  return passed(rows, columns, wider, (a, b, c) => (a + 2 * b + c) / 4);
}

/** Combines each node with its neighbours in the row, then in the column. */
function passed(rows, columns, from, combine) {
  const along = new Float32Array(from.length);
  const out = new Float32Array(from.length);
  const read = (array, r, c) =>
    array[Math.min(rows - 1, Math.max(0, r)) * columns + Math.min(columns - 1, Math.max(0, c))];
  const each = (target, take) => {
    for (let r = 0; r < rows; r += 1) {
      for (let c = 0; c < columns; c += 1) target[r * columns + c] = take(r, c);
    }
  };
  each(along, (r, c) => combine(read(from, r, c - 1), read(from, r, c), read(from, r, c + 1)));
  each(out, (r, c) => combine(read(along, r - 1, c), read(along, r, c), read(along, r + 1, c)));
  return out;
}

/**
 * Triangles of the mesh: two per cell that has any vertex inside.
 *
 * @param {number} rows
 * @param {number} columns
 * @param {Float32Array} cover of the vertices, inside above 0.5
 * @returns {Uint32Array} indices of vertices
 */
export function triangles(rows, columns, cover) {
  const index = [];
  for (let r = 0; r + 1 < rows; r += 1) {
    for (let c = 0; c + 1 < columns; c += 1) {
      const k = r * columns + c;
      const inside = Math.max(cover[k], cover[k + 1], cover[k + columns], cover[k + columns + 1]);
      if (inside <= 0.5) continue;
      index.push(k, k + 1, k + columns + 1, k, k + columns + 1, k + columns);
    }
  }
  return Uint32Array.from(index);
}

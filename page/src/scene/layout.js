/**
 * Where labels go so that they stay inside the picture, off each other, and off what they name.
 * Arithmetic only.
 */

const GAP = 4;

/** Px between a label and what it names: beside it, or further off at the end of a leader line. */
const AWAY = [11, 26, 44, 66, 92, 124, 160];
const [ROWS, COLUMNS] = [14, 8]; // of places all over the picture
const TURNS = 16; // directions around what is named
/** Off the level, beside what is named: an arrow comes from below. */
const RAISED = Math.PI / TURNS;

/** What covering costs, and crossing a leader line, in px of distance. */
const COVER_LABEL = 20000;
const COVER_CONTACT = 8000;
const COVER_ARROW = 500;
const COVERS = COVER_CONTACT / 4; // from which on anything is covered: no way is as long
const CROSS_LABEL = 300;
const CROSS = 150;
/** From which on another label has the first choice, where that helps; of many only the one that costs most. */
const FAR = 80;
const FEW = 5;
/** A label changes its place only for so much gain: it is not to jump to and fro. */
const STAY = 30;

/**
 * @typedef {{x: number, y: number, width: number, height: number, light?: boolean}} Box left, top
 *   and size in px; whether it is rather covered than others
 *
 * @typedef {object} Placed
 * @property {number} anchorX of what is labelled, px
 * @property {number} anchorY
 * @property {number} width px
 * @property {number} height
 * @property {-1|0|1|2} side where it stands best: left of the anchor, above it, right of it, below it
 * @property {boolean} [spare] better left out than covering anything, or standing far away
 * @property {boolean} [brief] better left out than covering anything
 * @property {number} [taken] the place it had before, set here
 * @property {number} x left edge, set here
 * @property {number} y top edge, set here
 * @property {boolean} [hidden] left out, set here: where it would cover another label
 */

/**
 * Sets x and y of each label; earlier ones have the better choice, but for one that would end far off.
 *
 * @param {Placed[]} labels
 * @param {Box[]} kept places that are not to be covered
 * @param {number} width of the picture, px
 * @param {number} height
 */
export function placeLabels(labels, kept, width, height) {
  let found = placesOf(labels, kept, width, height);
  const worst = found.reduce((one, other) => (other.cost > one.cost ? other : one), { cost: 0 });
  if (worst.cost > FAR && worst.cost < COVERS) {
    for (const first of labels.length > FEW ? [worst.label] : labels) {
      const order = [first, ...labels.filter((each) => each !== first)];
      const other = placesOf(order, kept, width, height);
      if (total(other) < total(found)) found = other;
    }
  }
  for (const { label, x, y, taken, hidden } of found) Object.assign(label, { x, y, taken, hidden });
}

function total(places) {
  return places.reduce((sum, { cost }) => sum + cost, 0);
}

/** A place for each label, one after the other. */
function placesOf(labels, kept, width, height) {
  const before = [];
  return labels.map((label) => {
    const best = { label, cost: Infinity, x: 0, y: 0, taken: 0 };
    const consider = (x, y, taken) => {
      label.x = clamp(x, GAP, width - label.width - GAP);
      label.y = clamp(y, GAP, height - label.height - GAP);
      const cost = costOf(label, before, kept) + (taken === label.taken ? -STAY : 0);
      if (cost < best.cost) Object.assign(best, { cost, x: label.x, y: label.y, taken });
    };
    around(label, consider);
    if (!label.spare) beside(label, before, consider);
    if (!label.spare && best.cost >= COVERS) anywhere(label, width, height, consider);
    best.hidden = best.cost >= (label.spare || label.brief ? COVERS : COVER_LABEL);
    Object.assign(label, { x: best.x, y: best.y });
    if (!best.hidden) before.push(label);
    return best;
  });
}

/** Places all around what is named, near and far. */
function around(label, consider) {
  const { anchorX, anchorY, width, height } = label;
  const rings = label.spare ? 1 : AWAY.length;
  for (let ring = 0; ring < rings; ring += 1) {
    for (let turn = 0; turn < TURNS; turn += 1) {
      const angle = bestAngle(label) + (turn * 2 * Math.PI) / TURNS;
      const [c, s] = [Math.cos(angle), -Math.sin(angle)];
      // From the middle of the label to where its border meets the direction
      const half = Math.min(width / 2 / Math.max(1e-9, Math.abs(c)), height / 2 / Math.max(1e-9, Math.abs(s)));
      const far = AWAY[ring] + half;
      consider(anchorX + c * far - width / 2, anchorY + s * far - height / 2, ring * TURNS + turn);
    }
  }
}

/** Places right above and below each label that is there already. */
function beside(label, before, consider) {
  before.forEach((other, i) => {
    for (const x of [other.x, label.anchorX + AWAY[0], label.anchorX - AWAY[0] - label.width]) {
      consider(x, other.y - label.height - GAP, -1 - 2 * i);
      consider(x, other.y + other.height + GAP, -2 - 2 * i);
    }
  });
}

/** Places all over the picture, where there is no room near by. */
function anywhere(label, width, height, consider) {
  for (let row = 0; row <= ROWS; row += 1) {
    for (let column = 0; column <= COLUMNS; column += 1) {
      const [x, y] = [(column / COLUMNS) * (width - label.width), (row / ROWS) * (height - label.height)];
      consider(x, y, 1000 + row * (COLUMNS + 1) + column);
    }
  }
}

function bestAngle({ side }) {
  if (side === 0) return Math.PI / 2;
  if (side === 2) return -Math.PI / 2;
  return side > 0 ? RAISED : Math.PI - RAISED;
}

function costOf(label, before, kept) {
  const [x, y] = leaderEnd(label);
  const { anchorX, anchorY } = label;
  let cost = Math.hypot(x - anchorX, y - anchorY);
  const angle = Math.atan2(anchorY - label.y - label.height / 2, label.x + label.width / 2 - anchorX);
  cost += 14 * Math.acos(Math.cos(angle - bestAngle(label)));
  for (const other of before) {
    if (overlap(label, widened(other))) cost += COVER_LABEL;
    else if (crosses(anchorX, anchorY, x, y, other)) cost += CROSS_LABEL;
    const [ox, oy] = leaderEnd(other);
    if (meet(anchorX, anchorY, x, y, other.anchorX, other.anchorY, ox, oy)) cost += CROSS;
  }
  for (const box of kept) cost += (box.light ? COVER_ARROW : COVER_CONTACT) * shareCovered(box, label);
  return cost;
}

/**
 * Where the leader line of a label ends: the place of its border next to what it names.
 *
 * @param {Placed} label @returns {[number, number]} px
 */
export function leaderEnd({ anchorX, anchorY, x, y, width, height }) {
  return [clamp(anchorX, x, x + width), clamp(anchorY, y, y + height)];
}

function widened({ x, y, width, height }) {
  return { x: x - 2, y: y - 2, width: width + 4, height: height + 4 };
}

/** More than nothing, however little is covered: a corner is not to be covered either. */
function shareCovered(box, by) {
  const wide = Math.min(box.x + box.width, by.x + by.width) - Math.max(box.x, by.x);
  const tall = Math.min(box.y + box.height, by.y + by.height) - Math.max(box.y, by.y);
  return wide > 0 && tall > 0 ? 0.25 + (0.75 * (wide * tall)) / (box.width * box.height) : 0;
}

/** Whether a line goes through a box (its middle cross, which is near enough). */
function crosses(ax, ay, bx, by, { x, y, width, height }) {
  return (
    meet(ax, ay, bx, by, x, y + height / 2, x + width, y + height / 2) ||
    meet(ax, ay, bx, by, x + width / 2, y, x + width / 2, y + height)
  );
}

function meet(ax, ay, bx, by, cx, cy, dx, dy) {
  const side = (px, py, qx, qy, rx, ry) => (qx - px) * (ry - py) - (qy - py) * (rx - px);
  return (
    side(ax, ay, bx, by, cx, cy) * side(ax, ay, bx, by, dx, dy) < 0 &&
    side(cx, cy, dx, dy, ax, ay) * side(cx, cy, dx, dy, bx, by) < 0
  );
}

/** @param {Box} a @param {Box} b @returns {boolean} whether two boxes cover each other */
export function overlap(a, b) {
  return (
    a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height
  );
}

function clamp(value, low, high) {
  return Math.max(low, Math.min(value, Math.max(low, high)));
}

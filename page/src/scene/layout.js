/**
 * Where labels go so that they stay inside the picture, off each other, and off what they name.
 * Arithmetic only.
 */

const GAP = 4;
const ASIDE = 11; // px between a label and what it names

/** What covering another label costs, and covering all of a contact, in px of distance. */
const COVER_LABEL = 4000;
const COVER_CONTACT = 260;
/** Shifts worth trying, px. */
const NUDGES = [16, -16, 32, -32, 48, -48, 64, -64, 80, -80];
/** A label changes its side only for so much gain: it is not to jump to and fro. */
const STAY = 20;

/**
 * @typedef {{x: number, y: number, width: number, height: number}} Box left, top and size in px
 *
 * @typedef {object} Placed
 * @property {number} anchorX of what is labelled, px
 * @property {number} anchorY
 * @property {number} width px
 * @property {number} height
 * @property {-1|0|1} side left of the anchor, above it, right of it
 * @property {number} [taken] the side it stood on before
 * @property {number} x left edge, set here
 * @property {number} y top edge, set here
 */

/**
 * Sets x and y of each label; earlier ones have the better choice.
 *
 * @param {Placed[]} labels
 * @param {Box[]} kept places that are better not covered
 * @param {number} width of the picture, px
 * @param {number} height
 */
export function placeLabels(labels, kept, width, height) {
  for (let i = 0; i < labels.length; i += 1) {
    const label = labels[i];
    let least = Infinity;
    let [x, y, taken] = [0, 0, label.side];
    for (const side of [label.side, -label.side, 0, 1, -1]) {
      label.x = clamp(wantedX(label, side), GAP, width - label.width - GAP);
      for (const shift of shifts(label, side, labels, i)) {
        label.y = clamp(shift, GAP, height - label.height - GAP);
        const cost = costOf(label, side, labels, i, kept);
        if (cost >= least) continue;
        least = cost;
        [x, y, taken] = [label.x, label.y, side];
      }
    }
    Object.assign(label, { x, y, taken });
  }
}

function wantedX({ anchorX, width }, side) {
  if (side === 0) return anchorX - width / 2;
  return side > 0 ? anchorX + ASIDE : anchorX - ASIDE - width;
}

function wantedY({ anchorY, height }, side) {
  return side === 0 ? anchorY - height - ASIDE : anchorY - height * 0.62;
}

/** Heights worth trying: as wanted, and just above and below each label that is there already. */
function shifts(label, side, labels, count) {
  const wanted = wantedY(label, side);
  const tries = [wanted, ...NUDGES.map((nudge) => wanted + nudge)];
  for (let i = 0; i < count; i += 1) {
    tries.push(labels[i].y - label.height - GAP, labels[i].y + labels[i].height + GAP);
  }
  return tries;
}

function costOf(label, side, labels, count, kept) {
  const dx = label.x - wantedX(label, label.side);
  const dy = label.y - wantedY(label, label.side);
  let cost = Math.hypot(0.35 * dx, dy);
  if (label.taken !== undefined && side !== label.taken) cost += STAY;
  for (let i = 0; i < count; i += 1) if (overlap(label, labels[i])) cost += COVER_LABEL;
  for (const box of kept) cost += COVER_CONTACT * shareCovered(box, label);
  return cost;
}

function shareCovered(box, by) {
  const wide = Math.min(box.x + box.width, by.x + by.width) - Math.max(box.x, by.x);
  const tall = Math.min(box.y + box.height, by.y + by.height) - Math.max(box.y, by.y);
  return wide > 0 && tall > 0 ? (wide * tall) / (box.width * box.height) : 0;
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

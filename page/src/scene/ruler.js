/**
 * Round lengths, for what is measured by: arithmetic only.
 */

/** @param {number} length m @returns {number} of 1, 2 and 5 × 10ⁿ the one that is nearest */
export function roundLength(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  const steps = [1, 2, 5, 10].map((step) => step * power);
  const off = (step) => Math.abs(Math.log(step / length));
  return steps.reduce((best, step) => (off(step) < off(best) ? step : best));
}

/** @param {number} longest m @returns {number} of 1, 2 and 5 × 10ⁿ the longest that is no longer */
export function rulerLength(longest) {
  const power = 10 ** Math.floor(Math.log10(longest));
  return [5, 2, 1].map((step) => step * power).find((step) => step <= longest * (1 + 1e-9)) ?? power;
}

/** @param {number} length m @returns {string} in the unit that reads best */
export function lengthWords(length) {
  if (length >= 0.9999) return `${Number(length.toPrecision(3))} m`;
  return length >= 0.0999 ? `${Number((100 * length).toPrecision(3))} cm` : `${Number((1e3 * length).toPrecision(3))} mm`;
}

/** Part of the slope at which a wall would hide what is behind it that dents are drawn with at most. */
const OPEN = 0.75;
const LEAST = 0.2; // from the side nothing is seen into

/**
 * The steepest wall of a dent that does not hide its bottom.
 *
 * @param {number} cosine of the angle between the skin's outer side and the direction to the camera
 * @returns {number} slope; infinite from right above
 */
export function steepestSeen(cosine) {
  const sine = Math.sqrt(Math.max(0, 1 - cosine * cosine));
  return sine > 1e-6 ? Math.max(LEAST, (OPEN * cosine) / sine) : Infinity;
}

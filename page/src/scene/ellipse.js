/**
 * Where a contact may be: the ellipse that holds its place so often. Arithmetic only.
 */

/** How often the true place is inside: as often as `Contact.place_radius` and the intervals say. */
export const LEVEL = 0.9;

/**
 * Ellipse of a normal distribution in the plane: r²/2 of its Mahalanobis radius is exponential.
 *
 * @param {[number, number, number]} covariance xx, xy, yy, m²
 * @param {number} [level]
 * @returns {{a: number, b: number, angle: number}|null} semi-axes, the longer first, m, and the angle
 *   from x to the longer one, rad; null where it is not known
 */
export function placeEllipse([xx, xy, yy], level = LEVEL) {
  const mean = 0.5 * (xx + yy);
  const half = Math.hypot(0.5 * (xx - yy), xy);
  if (!(mean > 0) || !(half <= mean * (1 + 1e-9)) || !Number.isFinite(mean)) return null;
  const times = Math.sqrt(-2 * Math.log(1 - level));
  return {
    a: times * Math.sqrt(mean + half),
    b: times * Math.sqrt(Math.max(0, mean - half)),
    angle: 0.5 * Math.atan2(2 * xy, xx - yy),
  };
}

/**
 * The outer border of a patch: straight lines around its taxels. Arithmetic only.
 */

/**
 * Convex hull, counterclockwise (Andrew 1979, monotone chain).
 *
 * @param {ArrayLike<number>} plane x and y of each point
 * @returns {Float64Array} x and y of the corners
 */
export function convexHull(plane) {
  const points = [];
  for (let i = 0; i + 1 < plane.length; i += 2) points.push([plane[i], plane[i + 1]]);
  points.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  if (points.length < 3) return Float64Array.from(points.flat());
  const half = (order) => {
    const chain = [];
    for (const point of order) {
      while (chain.length > 1 && turn(chain.at(-2), chain.at(-1), point) <= 0) chain.pop();
      chain.push(point);
    }
    chain.pop();
    return chain;
  };
  return Float64Array.from([...half(points), ...half([...points].reverse())].flat());
}

function turn(a, b, c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/**
 * Distance from a place to the hull's border, positive inside.
 *
 * @param {Float64Array} hull
 * @param {number} x
 * @param {number} y
 * @returns {number}
 */
export function depthInside(hull, x, y) {
  const corners = hull.length / 2;
  let least = Infinity;
  let inside = corners > 2;
  for (let i = 0; i < corners; i += 1) {
    const j = (i + 1) % corners;
    const ax = hull[2 * i];
    const ay = hull[2 * i + 1];
    const ux = hull[2 * j] - ax;
    const uy = hull[2 * j + 1] - ay;
    const square = ux * ux + uy * uy || 1;
    const t = Math.max(0, Math.min(1, ((x - ax) * ux + (y - ay) * uy) / square));
    least = Math.min(least, Math.hypot(x - ax - t * ux, y - ay - t * uy));
    if (ux * (y - ay) - uy * (x - ax) < 0) inside = false;
  }
  return inside ? least : -least;
}

import assert from "node:assert/strict";
import { test } from "node:test";
import { Refiner, coverage, nearestCovered, refinement, triangles } from "../src/scene/grid.js";
import { convexHull, depthInside } from "../src/scene/hull.js";

/** Repeatable numbers in 0..1 (Park and Miller 1988). */
function random(seed) {
  let state = seed;
  return () => (state = (state * 16807) % 2147483647) / 2147483647;
}

test("a mesh of all nodes has two triangles per cell, each vertex within the grid", () => {
  const index = triangles(4, 6, new Float32Array(24).fill(1));
  assert.equal(index.length, 3 * 5 * 2 * 3);
  assert.ok(Math.max(...index) === 23 && Math.min(...index) === 0);
  for (let i = 0; i < index.length; i += 3) assert.equal(new Set(index.slice(i, i + 3)).size, 3);
});

test("triangles wind one way, so that all show the same side", () => {
  const columns = 5;
  const index = triangles(4, columns, new Float32Array(20).fill(1));
  for (let i = 0; i < index.length; i += 3) {
    const [a, b, c] = [...index.slice(i, i + 3)].map((k) => [k % columns, Math.floor(k / columns)]);
    const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    assert.ok(area > 0);
  }
});

test("cells outside the cover have no triangles", () => {
  const cover = new Float32Array(25);
  cover[12] = 1;
  assert.equal(triangles(5, 5, cover).length, 4 * 2 * 3);
  assert.equal(triangles(5, 5, new Float32Array(25)).length, 0);
});

test("finer values agree with the nodes and stay between neighbours", () => {
  const next = random(7);
  const [rows, columns, factor] = [7, 9, 3];
  const values = Uint16Array.from({ length: rows * columns }, () => Math.floor(65535 * next()));
  const refiner = new Refiner(rows, columns, factor);
  const fine = refiner.apply(values, null, new Float32Array(refiner.count));
  assert.equal(refiner.fineRows, 19);
  assert.equal(refiner.fineColumns, 25);
  for (let r = 0; r < rows; r += 1) {
    for (let c = 0; c < columns; c += 1) {
      const at = fine[r * factor * refiner.fineColumns + c * factor];
      assert.ok(Math.abs(at - values[r * columns + c]) < 0.02);
    }
  }
  for (let r = 0; r < refiner.fineRows; r += 1) {
    for (let c = 0; c < refiner.fineColumns; c += 1) {
      const [y, x] = [Math.min(5, Math.floor(r / factor)), Math.min(7, Math.floor(c / factor))];
      const around = [0, 1, columns, columns + 1].map((more) => values[y * columns + x + more]);
      const value = fine[r * refiner.fineColumns + c];
      assert.ok(value >= Math.min(...around) - 0.1 && value <= Math.max(...around) + 0.1);
    }
  }
});

test("a straight slope stays straight between the nodes", () => {
  const values = Float32Array.from({ length: 30 }, (_, k) => 3 * (k % 6) - Math.floor(k / 6));
  const refiner = new Refiner(5, 6, 4);
  const fine = refiner.apply(values, null, new Float32Array(refiner.count), { bounded: false });
  const [r, c] = [6, 9];
  assert.ok(Math.abs(fine[r * refiner.fineColumns + c] - (3 * (c / 4) - r / 4)) < 1e-4);
});

test("the mesh is finer where there are few nodes, and coarse where there are many patches", () => {
  assert.equal(refinement(40, 40, 1), 2);
  assert.equal(refinement(10, 10, 1), 8);
  assert.equal(refinement(40, 40, 20), 1);
  assert.equal(refinement(200, 200, 3), 1);
});

test("a node that is not covered shows the value of a neighbour that is", () => {
  const covered = new Uint8Array(25);
  covered[12] = 1;
  const source = nearestCovered(5, 5, covered, 2);
  assert.ok(source.every((k) => k === 12));
  assert.equal(nearestCovered(5, 5, covered, 1)[0], 0);
});

test("cover is 1 deep inside and 0 far outside", () => {
  const covered = Uint8Array.from({ length: 81 }, (_, k) => {
    return Math.abs((k % 9) - 4) <= 2 && Math.abs(Math.floor(k / 9) - 4) <= 2 ? 1 : 0;
  });
  const cover = coverage(9, 9, covered);
  assert.equal(cover[40], 1);
  assert.ok(cover[0] < 0.1);
  assert.ok(cover[9 * 4 + 7] > 0.5, "one node beyond");
  assert.ok(cover[9 * 4 + 8] < 0.5, "not two");
});

test("a hull holds all its points, and its depth is the distance to the border", () => {
  const next = random(3);
  const points = Array.from({ length: 200 }, () => next() - 0.5);
  const hull = convexHull(points);
  for (let i = 0; i < points.length; i += 2) {
    assert.ok(depthInside(hull, points[i], points[i + 1]) > -1e-12);
  }
  const square = convexHull([0, 0, 2, 0, 2, 2, 0, 2, 1, 1, 1, 0]);
  assert.equal(square.length, 8);
  assert.equal(depthInside(square, 1, 0.25), 0.25);
  assert.equal(depthInside(square, 5, 6), -5);
});

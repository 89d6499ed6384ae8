import assert from "node:assert/strict";
import { test } from "node:test";
import { overlap, placeLabels } from "../src/scene/layout.js";

const label = (anchorX, anchorY, side) => ({ anchorX, anchorY, side, width: 120, height: 40, x: 0, y: 0 });

test("labels at one place do not cover each other", () => {
  const labels = Array.from({ length: 8 }, (_, i) => label(300, 200 + i, i % 2 ? 1 : -1));
  placeLabels(labels, [], 800, 600);
  for (const a of labels) for (const b of labels) assert.ok(a === b || !overlap(a, b));
});

test("labels stay inside the picture", () => {
  const labels = [label(-50, -50, 1), label(900, 900, 0), label(799, 300, 1), label(0, 599, -1)];
  placeLabels(labels, [], 800, 600);
  for (const { x, y, width, height } of labels) {
    assert.ok(x >= 0 && y >= 0 && x + width <= 800 && y + height <= 600);
  }
});

test("a label alone stands beside what it names", () => {
  const [right, left, above] = [label(300, 200, 1), label(300, 200, -1), label(300, 200, 0)];
  for (const one of [right, left, above]) placeLabels([one], [], 800, 600);
  assert.ok(right.x > 300 && left.x + left.width < 300 && above.y + above.height < 200);
});

test("labels leave contacts free, and do not jump back and forth", () => {
  const one = label(300, 200, 1);
  const contact = { x: 330, y: 190, width: 30, height: 30 };
  placeLabels([one], [contact], 800, 600);
  assert.ok(!overlap(one, contact));
  const { x, y, taken } = one;
  placeLabels([one], [contact], 800, 600);
  assert.deepEqual([one.x, one.y, one.taken], [x, y, taken]);
});

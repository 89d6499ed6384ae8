import assert from "node:assert/strict";
import { test } from "node:test";
import { leaderEnd, overlap, placeLabels } from "../src/scene/layout.js";

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

test("no label stands far off where all have room near by", () => {
  const card = (anchorX, anchorY, side) => ({ ...label(anchorX, anchorY, side), width: 215, height: 42 });
  const labels = [card(582, 53, 1), card(379, 71, 1), card(463, 16, 1), card(505, 164, 1)];
  const tips = [[574, 133], [385, 149], [463, 90], [502, 240]];
  const rings = tips.map(([x, y]) => ({ x: x - 25, y: y - 16, width: 50, height: 32 }));
  const arrows = labels.map(({ anchorX: x, anchorY: y }) => ({ x: x - 7, y, width: 14, height: 70, light: true }));
  const far = () => labels.map((each) => {
    const [x, y] = leaderEnd(each);
    return Math.hypot(x - each.anchorX, y - each.anchorY);
  });
  for (let turn = 0; turn < 3; turn += 1) {
    placeLabels(labels, [...rings, ...arrows], 927, 383);
    assert.ok(Math.max(...far()) < 60, `${far()}`);
    for (const a of labels) for (const b of labels) assert.ok(a === b || !overlap(a, b));
  }
});

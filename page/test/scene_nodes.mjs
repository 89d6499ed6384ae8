import assert from "node:assert/strict";
import { test } from "node:test";
import { borderOf } from "../src/scene/border.js";
import { Nodes } from "../src/scene/nodes.js";

const COUNT = 11;
const PITCH = 0.004;
const RADIUS = 0.05;

/** A patch of 11 x 11 nodes, its middle at x = y = 0; flat, or around a cylinder along y. */
function geometry(curved) {
  const [positions, normals, plane, covered] = [[], [], [], []];
  for (let r = 0; r < COUNT; r += 1) {
    for (let c = 0; c < COUNT; c += 1) {
      const [x, y] = [(c - 5) * PITCH, (r - 5) * PITCH];
      const [sin, cos] = curved ? [Math.sin(x / RADIUS), Math.cos(x / RADIUS)] : [0, 1];
      plane.push(x, y);
      positions.push(curved ? RADIUS * sin : x, y, curved ? RADIUS * cos : 0);
      normals.push(sin, 0, cos);
      covered.push(Math.abs(c - 5) <= 4 && Math.abs(r - 5) <= 4 ? 1 : 0);
    }
  }
  const head = { patch: 3, rung: 11, rows: COUNT, columns: COUNT };
  return [head, { positions, normals, plane, covered }];
}

const place = () => ({ position: [0, 0, 0], normal: [0, 0, 1] });
const near = (a, b, within) => a.every((value, i) => Math.abs(value - b[i]) < within);

for (const pad of [0, 2]) {
  test(`places between nodes, with ${pad} nodes added around`, () => {
    const nodes = new Nodes(...geometry(true), pad);
    assert.equal(nodes.given, COUNT * COUNT);
    const out = place();
    assert.ok(nodes.at(0.0051, -0.0033, 0, out));
    const angle = 0.0051 / RADIUS;
    const exact = [RADIUS * Math.sin(angle), -0.0033, RADIUS * Math.cos(angle)];
    assert.ok(near(out.position, exact, 6e-5), "within the sagitta of a cell");
    assert.ok(near(out.normal, [Math.sin(angle), 0, Math.cos(angle)], 1e-3));
    assert.equal(nodes.at(1, 1, 0, out), false, "far outside is not on the skin");
  });

  test(`a ray finds the place that is seen, with ${pad} nodes added around`, () => {
    const nodes = new Nodes(...geometry(true), pad);
    const aim = place();
    nodes.at(-0.0062, 0.0087, 0, aim);
    const from = [0.03, 0.1, 0.4];
    const way = aim.position.map((value, i) => value - from[i]);
    const long = Math.hypot(...way);
    const hit = nodes.hit(from, way.map((value) => value / long), 0);
    assert.ok(Math.abs(hit.x + 0.0062) < 5e-5 && Math.abs(hit.y - 0.0087) < 5e-5);
    assert.ok(Math.abs(hit.distance - long) < 1e-4);
  });
}

test("a ray from behind, or beside the skin, meets nothing", () => {
  const nodes = new Nodes(...geometry(false));
  assert.equal(nodes.hit([0, 0, -1], [0, 0, 1], 0), null);
  assert.equal(nodes.hit([0.1, 0, 1], [0, 0, -1], 0), null);
  assert.ok(nodes.hit([0, 0, 1], [0, 0, -1], 0));
});

test("heights sink the skin along its normal, by their scale", () => {
  const nodes = new Nodes(...geometry(false), 1);
  const height = new Uint16Array(COUNT * COUNT);
  height[5 * COUNT + 5] = 1000;
  nodes.setHeight(height);
  const out = place();
  nodes.at(0, 0, 2e-6, out);
  assert.ok(near(out.position, [0, 0, -2e-3], 1e-7));
  nodes.at(PITCH / 2, 0, 2e-6, out);
  assert.ok(near(out.position, [PITCH / 2, 0, -1e-3], 1e-7));
  assert.ok(Math.abs(nodes.hit([0, 0, 1], [0, 0, -1], 2e-6).distance - 1.002) < 1e-6);
  assert.ok(Math.abs(nodes.hit([0, 0, 1], [0, 0, -1], 0).distance - 1) < 1e-9, "at rest");
  nodes.setHeight(null);
  assert.ok(nodes.height.every((value) => value === 0));
});

test("beyond the covered nodes, values are those of the nearest covered one", () => {
  const nodes = new Nodes(...geometry(false), 1);
  const height = Uint16Array.from({ length: COUNT * COUNT }, (_, k) => k);
  nodes.setHeight(height);
  const corner = 1 * COUNT + 1;
  assert.equal(nodes.height[nodes.columns * 1 + 1], corner, "the corner of what is covered");
});

test("the border of a patch goes around its taxels, on curved skin too", () => {
  const [, arrays] = geometry(true);
  const taxels = [];
  for (const [x, y] of [[-0.0151, -0.0149], [0.0151, -0.0149], [0.0151, 0.0149], [-0.0151, 0.0149]]) {
    taxels.push(RADIUS * Math.sin(x / RADIUS), y, RADIUS * Math.cos(x / RADIUS));
  }
  const border = borderOf({ ...arrays, taxels }, 0.005);
  assert.equal(border.hull.length, 8);
  for (let i = 0; i < 8; i += 2) {
    assert.ok(Math.abs(Math.abs(border.hull[i]) - 0.0151) < 1e-4);
    assert.ok(Math.abs(Math.abs(border.hull[i + 1]) - 0.0149) < 1e-6);
  }
  assert.equal(borderOf(arrays, 0.005), null, "without taxels there is none");
});

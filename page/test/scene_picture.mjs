import assert from "node:assert/strict";
import { test } from "node:test";
import * as THREE from "three";
import { OrbitCamera } from "../src/scene/camera.js";
import { mapColour, mapGradient, mapTable } from "../src/scene/colours.js";
import { placeEllipse } from "../src/scene/ellipse.js";
import { leaderEnd, overlap, placeLabels } from "../src/scene/layout.js";
import { Nodes } from "../src/scene/nodes.js";
import { lengthWords, roundLength, rulerLength, steepestSeen } from "../src/scene/ruler.js";
import { THEMES } from "../src/scene/theme.js";

const close = (a, b, off) => assert.ok(Math.abs(a - b) <= off, `${a} is not ${b} within ${off}`);
const corners = (wide, tall) => [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => new THREE.Vector3((x * wide) / 2, (y * tall) / 2, 0));

/** Part of the picture that points fill, across and along. */
function filled(view, points) {
  const seen = points.map((at) => at.clone().project(view.camera));
  const span = (axis) => Math.max(...seen.map((at) => at[axis])) - Math.min(...seen.map((at) => at[axis]));
  return [span("x") / 2, span("y") / 2];
}

for (const [width, height] of [[927, 517], [380, 640], [600, 600]]) {
  for (const [wide, tall] of [[0.05, 0.05], [0.3, 0.05], [0.04, 0.2]]) {
    test(`a skin of ${wide} m by ${tall} m fills ${width} x ${height} px`, () => {
      const view = new OrbitCamera();
      const points = corners(wide, tall);
      view.setSubject(points, new THREE.Vector3(0, 0, 1));
      view.resize(300, 300);
      view.resize(width, height);
      const [across, along] = filled(view, points);
      assert.ok(Math.max(across, along) > 0.85, `${across}, ${along}`);
      assert.ok(Math.max(across, along) < 0.97);
    });
  }
}

test("a view that was turned keeps its place when the picture changes its size", () => {
  const view = new OrbitCamera();
  view.setSubject(corners(0.05, 0.05), new THREE.Vector3(0, 0, 1));
  view.resize(900, 500);
  view.orbit(0.3, 0.1);
  const before = view.camera.position.clone();
  view.resize(700, 500);
  assert.ok(before.distanceTo(view.camera.position) < 1e-12);
});

test("a pixel and the place seen there find each other", () => {
  const view = new OrbitCamera();
  view.setSubject(corners(0.05, 0.05), new THREE.Vector3(0, 0, 1));
  view.resize(900, 500);
  const seen = view.at(123, 456).project(view.camera);
  close((seen.x + 1) * 450, 123, 1e-6);
  close((1 - seen.y) * 250, 456, 1e-6);
  close(view.at(450, 250).distanceTo(view.target), 0, 1e-9);
});

test("where an arrow ends is the same pixel however deep the dent is drawn", () => {
  const [count, pitch] = [9, 1e-3];
  const plane = Array.from({ length: count * count }, (_, k) => [((k % count) - 4) * pitch, (Math.floor(k / count) - 4) * pitch]);
  const arrays = { plane: plane.flat(), positions: plane.flatMap(([x, y]) => [x, y, 0]), normals: plane.flatMap(() => [0, 0, 1]), covered: plane.map(() => 1) };
  const nodes = new Nodes({ patch: 0, rung: count, rows: count, columns: count }, arrays);
  nodes.setHeight(plane.map(([x, y]) => 1000 + 5000 * Math.exp(-(x * x + y * y) / 4e-6)), 1000);
  const view = new OrbitCamera();
  view.setSubject(corners(0.01, 0.01), new THREE.Vector3(0, 0, 1));
  view.resize(900, 500);
  const out = { position: [0, 0, 0], normal: [0, 0, 1] };
  const pixel = ([x, y, z]) => view.camera && new THREE.Vector3(x, y, z).project(view.camera);
  nodes.at(5e-4, 0, 0, out);
  const rest = pixel(out.position);
  close(rest.distanceTo(pixel([5e-4, 0, 0])), 0, 1e-6);
  nodes.at(5e-4, 0, 1e-7 * 30, out);
  assert.ok(out.position[2] < -5e-3, "the dent itself is deep");
  assert.ok(Math.abs(pixel(out.position).y - rest.y) * 250 > 30, "and is seen elsewhere");
});

test("heights go both ways from the skin at rest", () => {
  const arrays = { plane: [0, 0, 1e-3, 0], positions: [0, 0, 0, 1e-3, 0, 0], normals: [0, 0, 1, 0, 0, 1], covered: [1, 1] };
  const nodes = new Nodes({ patch: 0, rung: 2, rows: 1, columns: 2 }, arrays);
  nodes.setHeight([0, 300], 100);
  assert.deepEqual([...nodes.height], [-100, 200]);
});

test("four contacts and their labels do not cover each other", () => {
  const places = [[310, 250], [640, 240], [470, 120], [460, 330]];
  const labels = places.map(([x, y]) => ({ anchorX: x, anchorY: y - 70, side: 1, width: 230, height: 42 }));
  const kept = places.flatMap(([x, y]) => [
    { x: x - 36, y: y - 24, width: 72, height: 48 },
    { x: x - 7, y: y - 70, width: 14, height: 70 },
  ]);
  placeLabels(labels, kept, 927, 517);
  for (const a of labels) {
    for (const b of labels) assert.ok(a === b || !overlap(a, b));
    for (const box of kept) assert.ok(!overlap(a, box), "a contact is covered");
    const [x, y] = leaderEnd(a);
    assert.ok(Math.hypot(x - a.anchorX, y - a.anchorY) < 170, "it is near what it names");
  }
});

test("a name that has no room is left out", () => {
  const first = { anchorX: 100, anchorY: 100, side: 2, width: 90, height: 20 };
  const name = { anchorX: 100, anchorY: 100, side: 2, width: 90, height: 20, spare: true };
  placeLabels([first, name], [{ x: 0, y: 0, width: 300, height: 200 }], 300, 200);
  assert.ok(name.hidden && !first.hidden);
  delete name.taken;
  placeLabels([name], [], 300, 200);
  assert.ok(!name.hidden && name.y > 100);
});

test("the ellipse of a place holds nine in ten of a normal distribution", () => {
  const [sx, sy, tilt] = [2e-3, 0.5e-3, 0.6];
  const [c, s] = [Math.cos(tilt), Math.sin(tilt)];
  const covariance = [c * c * sx ** 2 + s * s * sy ** 2, c * s * (sx ** 2 - sy ** 2), s * s * sx ** 2 + c * c * sy ** 2];
  const { a, b, angle } = placeEllipse(covariance);
  close(angle, tilt, 1e-9);
  close(a / b, sx / sy, 1e-9);
  // By quantiles: r² / 2 of a round distribution is exponential, at steps of equal probability
  let inside = 0;
  for (let i = 0; i < 4000; i += 1) inside += sx * Math.sqrt(-2 * Math.log(1 - (i + 0.5) / 4000)) < a;
  close(inside / 4000, 0.9, 1e-3);
  assert.equal(placeEllipse([null, null, null]), null);
  assert.equal(placeEllipse([NaN, 0, 1]), null);
});

test("no wall is steeper than the line of sight", () => {
  for (const angle of [0.2, 0.6, 0.78, 1.2]) {
    const sight = Math.tan(Math.PI / 2 - angle); // slope of the line from the camera
    const slope = steepestSeen(Math.cos(angle));
    assert.ok(slope < sight && slope > 0.5 * sight);
  }
  assert.equal(steepestSeen(1), Infinity);
  assert.ok(steepestSeen(-0.5) > 0);
});

test("round lengths, and their words", () => {
  assert.deepEqual([0.0047, 0.0059, 0.03, 0.09].map(roundLength).map((x) => Number(x.toPrecision(3))), [0.005, 0.005, 0.02, 0.1]);
  assert.deepEqual([0.0199, 0.02, 0.051].map(rulerLength).map((x) => Number(x.toPrecision(3))), [0.01, 0.02, 0.05]);
  assert.deepEqual([0.005, 0.1, 0.02, 1].map(lengthWords), ["5 mm", "10 cm", "20 mm", "1 m"]);
});

for (const [name, theme] of Object.entries(THEMES)) {
  test(`maps begin with the ${name} skin's own colour, and the colour bar with it`, () => {
    const own = [1, 3, 5].map((at) => Number.parseInt(theme.plain.slice(at, at + 2), 16));
    for (const map of ["viridis", "cividis", "plasma"]) {
      assert.deepEqual(mapColour(map, 0, theme), own);
      assert.deepEqual(mapColour(map, 1, theme), mapColour(map, theme.bright ? 0 : 1));
      assert.deepEqual(mapColour(map, 0.5, theme).map(Math.round), [...mapTable(map).slice(4 * (theme.bright ? 127 : 128), 4 * (theme.bright ? 127 : 128) + 3)]);
      assert.ok(mapGradient(map, "to right", theme).startsWith(`linear-gradient(to right, rgb(${own.join(" ")})`));
    }
    assert.ok(Math.max(...own) - Math.min(...own) < 25, "neutral");
  });
}

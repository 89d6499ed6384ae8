import assert from "node:assert/strict";
import { test } from "node:test";
import * as format from "../src/format.js";
import { CalmRange, roundUp } from "../src/autorange.js";

test("units are the ones that read best", () => {
  const cases = [
    [[1530, "Pa"], "1.53 kPa"], [[999, "Pa"], "999 Pa"], [[1000, "Pa"], "1.00 kPa"], [[2.5e6, "Pa"], "2.50 MPa"],
    [[0.00123, "m"], "1.23 mm"], [[0.0000456, "m"], "0.0456 mm"], [[0.05, "N"], "50.0 mN"], [[-2, "N"], "−2.00 N"],
    [[0.25, "1"], "0.250 ΔC/C₀"], [[3, ""], "3.00"], [[NaN, "Pa"], "–"], [[undefined, "m"], "–"], [[0, "Pa"], "0 Pa"],
    [[1530, "relative"], "1.53 relative"], [[30, "relative"], "0.0300 relative"],
  ];
  for (const [args, wanted] of cases) assert.equal(format.quantity(...args), wanted);
});

test("times, bytes and counts", () => {
  assert.equal(format.micros(182.4), "182 µs");
  assert.equal(format.micros(1530), "1.53 ms");
  assert.equal(format.micros(2.5e6), "2.50 s");
  assert.equal(format.micros(null), "–");
  assert.equal(format.clock(0), "0:00.0");
  assert.equal(format.clock(75.25), "1:15.2");
  assert.equal(format.clock(59.99), "0:59.9");
  assert.equal(format.clock(-1.5), "−0:01.5");
  assert.equal(format.bytes(198000), "198 kB");
  assert.equal(format.bytes(0), "0 B");
  assert.equal(format.count(1234567), "1\u202f234\u202f567");
  assert.equal(format.fixed(-0.04, 1), "0.0");
  assert.equal(format.fixed(-0.06, 1), "−0.1");
});

test("a force along the skin has its direction", () => {
  const shear = { size: 0.5, std: 0.04, angle: -Math.PI / 6, vector: [0.43, -0.25, 0] };
  assert.equal(format.shearWords(shear), "0.50 ± 0.04 along the skin, −30° from x");
  assert.ok(format.contactWords({ shape: "flat", radius: NaN, shear }).startsWith("flat; 0.50 ± 0.04 along"));
});

test("ticks are round, within the range, and told apart", () => {
  assert.deepEqual(format.ticks(0, 50, 5), [0, 10, 20, 30, 40, 50]);
  assert.deepEqual(format.ticks(0, 1, 4), [0, 0.25, 0.5, 0.75, 1]);
  assert.deepEqual(format.ticks(3, 3), []);
  for (const hi of [1e-6, 0.7, 3, 47, 1e5]) {
    const values = format.ticks(-hi / 3, hi, 4);
    assert.ok(values.length >= 3 && values.length <= 8, `${hi}: ${values}`);
    assert.ok(values[0] >= -hi / 3 - 1e-9 && values.at(-1) <= hi * 1.000001);
    const places = format.placesOf(values[1] - values[0]);
    assert.equal(new Set(values.map((v) => v.toFixed(places))).size, values.length);
  }
});

test("the range grows at once, in round steps, and shrinks after a while", () => {
  assert.deepEqual([0, 1, 1.2, 2.1, 9, 0.03].map(roundUp), [0, 1, 2, 5, 10, 0.05]);
  const range = new CalmRange();
  assert.deepEqual(range.value, [0, 1]);
  assert.deepEqual(range.follow([0, 3], 0), [0, 5]);
  assert.deepEqual(range.follow([0, 30], 0.1), [0, 50]);
  assert.deepEqual(range.follow([0, 3], 0.2), [0, 50]);
  assert.deepEqual(range.follow([0, 8], 2), [0, 50]);
  assert.deepEqual(range.follow([0, 3], 3.3), [0, 10]);
  assert.deepEqual(range.follow([0, 0], 20), [0, 10], "nothing to be seen keeps what was");
  assert.deepEqual(range.follow([0, 0], 40), [0, 10]);
  assert.deepEqual(range.follow([NaN, null], 41), [0, 10]);
  range.reset();
  assert.deepEqual(range.follow([-3, 1], 0), [-5, 1]);
});

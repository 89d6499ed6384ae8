import assert from "node:assert/strict";
import { test } from "node:test";
import { LEVELS, MAP_OF, mapColour, mapGradient, mapNames, mapTable } from "../src/scene/colours.js";

/** Lightness L* of CIE 1976 of an sRGB colour, 0..100. */
function lightness([r, g, b]) {
  const linear = [r, g, b].map((value) => {
    const v = value / 255;
    return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  });
  const y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  return y > 0.008856 ? 116 * Math.cbrt(y) - 16 : 903.3 * y;
}

const all = (name) => Array.from({ length: LEVELS }, (_, i) => mapColour(name, i / (LEVELS - 1)));

for (const name of mapNames()) {
  test(`${name} becomes lighter from low to high, in even steps`, () => {
    const values = all(name).map(lightness);
    const steps = values.slice(1).map((value, i) => value - values[i]);
    assert.ok(Math.min(...steps) > -0.35, "a step down in lightness beyond rounding");
    assert.ok(Math.max(...steps) < 1.2, "a jump in lightness");
    assert.ok(values.at(-1) - values[0] > 60, "the whole range is told by lightness alone");
  });
}

test("known colours of the maps", () => {
  assert.deepEqual(mapColour("viridis", 0), [68, 1, 84]);
  assert.deepEqual(mapColour("viridis", 1), [253, 231, 37]);
  assert.deepEqual(mapColour("cividis", 0), [0, 34, 78]);
  assert.deepEqual(mapColour("plasma", 1), [240, 249, 33]);
});

test("values beyond the ends have the end's colour", () => {
  assert.deepEqual(mapColour("viridis", -1), mapColour("viridis", 0));
  assert.deepEqual(mapColour("viridis", 7), mapColour("viridis", 1));
});

test("every quantity has a map, and an unknown map is refused by name", () => {
  for (const map of Object.values(MAP_OF)) assert.equal(mapTable(map).length, 4 * LEVELS);
  assert.throws(() => mapTable("jet"), /jet.*viridis/);
  assert.match(mapGradient("viridis", "to top"), /^linear-gradient\(to top, rgb\(68 1 84\)/);
});

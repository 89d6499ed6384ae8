import assert from "node:assert/strict";
import { test } from "node:test";
import { LookBack } from "../src/lookback.js";
import { unbroken } from "../src/time_series.js";

/** An update in which patches changed, with what one array holds of each. */
function update(values, contacts = [], rows = []) {
  const patches = Object.keys(values).map((i) => ({ i: Number(i), colour: Number(i) }));
  const arrays = [];
  for (const [i, value] of Object.entries(values)) arrays[i] = [value];
  return [{ patches, contacts, rows }, arrays];
}

/** What each patch showed at a moment. */
function shown(back, place) {
  const found = [...back.moment(place).parts].map(([i, { entry, arrays }]) => [i, arrays[entry.colour][0]]);
  return Object.fromEntries(found.sort());
}

test("a moment has every patch as it was, whatever changed last", () => {
  const back = new LookBack({ seconds: 10 });
  back.add(0, ...update({ 0: "a0", 1: "b0" }));
  for (let t = 1; t <= 40; t += 1) back.add(t, ...update({ 0: `a${t}` }));
  assert.equal(back.length, 11);
  assert.deepEqual([back.start, back.end], [30, 40]);
  assert.deepEqual(shown(back, 0), { 0: "a30", 1: "b0" }); // that of patch 1 is older than what is kept
  assert.deepEqual(shown(back, 10), { 0: "a40", 1: "b0" });
  assert.deepEqual([29, 30, 34.5, 40, 99].map((t) => back.moment(back.placeAt(t)).time), [30, 30, 34, 40, 40]);
});

test("memory stays bounded in bytes, and one moment is always there", () => {
  const back = new LookBack({ seconds: 1e9, bytes: 1000 });
  for (let t = 0; t < 500; t += 1) back.add(t, ...update({ 0: t }), 300);
  assert.equal(back.length, 3);
  back.add(500, ...update({ 0: 500 }), 5000);
  assert.equal(back.length, 1);
  assert.deepEqual(shown(back, 0), { 0: 500 });
});

test("while it is held nothing goes, and afterwards nothing is missing", () => {
  const back = new LookBack({ seconds: 5 });
  assert.equal(back.hold(), false);
  back.add(0, ...update({ 0: "a0", 1: "b0" }));
  assert.equal(back.hold(), true);
  for (let t = 1; t < 100; t += 1) back.add(t, ...update(t === 50 ? { 1: "b50" } : { 0: `a${t}` }));
  assert.deepEqual([back.length, back.end], [1, 0]);
  back.release();
  assert.deepEqual([back.held, back.length, back.end], [false, 1, 99]);
  assert.deepEqual(shown(back, 0), { 0: "a99", 1: "b50" });
});

test("an update without a new reading replaces its own; time that goes back begins anew", () => {
  const back = new LookBack();
  back.add(1, ...update({ 0: "a", 1: "b" }));
  back.add(1, ...update({ 0: "c" }));
  assert.equal(back.length, 1);
  assert.deepEqual(shown(back, 0), { 0: "c", 1: "b" });
  back.add(0.5, ...update({ 0: "d" }));
  assert.deepEqual(shown(back, 0), { 0: "d" });
});

test("force over time, touches from begin to end, and each row once", () => {
  const back = new LookBack();
  const [one, two] = [{ key: "s 1", force: 1 }, { key: "s 2", force: 0.5 }];
  back.add(0, ...update({}, [], []));
  back.add(1, ...update({}, [one], ["1,a"]));
  back.add(2, ...update({}, [one, two], ["1,a", "2,b"]));
  back.add(3, ...update({}, [two], ["3,b"]));
  assert.deepEqual(back.outline(), { times: [0, 1, 2, 3], force: [0, 1, 1.5, 0.5], touches: [[1, 2], [2, 3]] });
  assert.deepEqual(back.rows(), ["1,a", "2,b", "3,b"]);
});

test("the strip breaks where nothing was told", () => {
  assert.deepEqual(unbroken([0, 0.5, 1, 4, 4.5, 9], 1), [[0, 3], [3, 5], [5, 6]]);
  assert.deepEqual(unbroken([], 1), []);
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { matched, unfound } from "../src/truth_match.js";
import { Series, Slots } from "../src/time_series.js";

test("rows of the newest seconds, one beyond the edge", () => {
  const series = new Series(2, 30);
  for (let i = 0; i <= 100; i += 1) series.push(i, [i, i % 2 ? NaN : -i]);
  const [times, first, second] = series.rows(10);
  assert.deepEqual(times, [89, 90, 91, 92, 93, 94, 95, 96, 97, 98, 99, 100]);
  assert.deepEqual(first, times);
  assert.deepEqual(second, times.map((t) => (t % 2 ? null : -t)));
  assert.equal(series.length, 31);
});

test("memory stays bounded over a long run", () => {
  const series = new Series(1, 1);
  for (let i = 0; i < 50000; i += 1) series.push(i / 100, [i]);
  assert.equal(series.length, 101);
  assert.equal(series.rows(0.05)[0].length, 7);
});

test("going back in time begins anew, no time is passed over", () => {
  const series = new Series(1, 30);
  series.push(5, [1]);
  series.push(6, [2]);
  series.push(2, [3]);
  assert.deepEqual(series.rows(10), [[2], [3]]);
  series.push(NaN, [4]);
  series.push(undefined, [4]);
  assert.equal(series.length, 1);
  series.push(100, [5]);
  assert.deepEqual(series.rows(10), [[100], [5]]);
});

test("a row of the same time replaces the one before", () => {
  const series = new Series(1, 30);
  series.push(5, [1]);
  series.push(5, [2]);
  series.push(5, [NaN]);
  assert.deepEqual(series.rows(10), [[5], [null]]);
});

test("a track keeps its colour, and colours come back after a while", () => {
  const slots = new Slots(2, 10);
  assert.equal(slots.of(7, 0), 0);
  assert.equal(slots.of(8, 0), 1);
  assert.equal(slots.of(7, 5), 0);
  assert.equal(slots.of(9, 5), -1);
  assert.equal(slots.of(9, 11), 1);
  assert.equal(slots.of(7, 12), 0);
});

const place = (x, y, more = {}) => ({ patch: 0, x, y, force: 1, ...more });

test("contacts are matched with the nearest press, each once", () => {
  const near = place(0.001, 0, { force: 2 });
  const far = place(0.01, 0);
  const rows = matched([place(0.009, 0, { force: 1.1 }), place(0, 0)], [far, near]);
  assert.equal(rows[0].truth, far);
  assert.equal(rows[1].truth, near);
  assert.ok(Math.abs(rows[0].error_m - 0.001) < 1e-12);
  assert.ok(Math.abs(rows[0].error_percent - 10) < 1e-9);
  assert.ok(Math.abs(rows[1].error_percent + 50) < 1e-9);
});

test("neither another patch nor a place far away is a match", () => {
  const truths = [place(0, 0, { patch: 1 }), place(0.2, 0)];
  const rows = matched([place(0, 0)], truths);
  assert.equal(rows[0].truth, null);
  assert.ok(Number.isNaN(rows[0].error_m));
  assert.deepEqual(unfound(rows, truths), truths);
  assert.deepEqual(unfound(rows, [place(0, 0, { force: 0 })]), []);
});

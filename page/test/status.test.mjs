import assert from "node:assert/strict";
import { test } from "node:test";
import { colourOf, notesOf, statusWords, timesOf } from "../src/status.js";

const engine = (more = {}) => ({
  name: "a",
  state: "running",
  rate: 999.7,
  since_start: { late: 4 },
  lately: { latency_us: { p50: 182, p99: 1530, count: 9 } },
  ...more,
});

test("a running engine in one line", () => {
  const words = statusWords({ state: "running", engines: [engine()] });
  assert.deepEqual(words, ["running", "1\u202f000 estimates/s", "latency 182 µs, p99 1.53 ms", "4 late"]);
  assert.equal(colourOf("running"), "good");
});

test("one of three is gone: said, and not averaged away", () => {
  const gone = { name: "c", state: "failed", notes: ["it was killed"] };
  const engines = [engine(), engine({ name: "b", since_start: { late: 0 } }), gone];
  const words = statusWords({ state: "mixed", engines });
  assert.equal(words[0], "2 of 3 engines run");
  assert.equal(words[1], "1\u202f000 estimates/s");
  assert.equal(colourOf("mixed"), "waiting");
  assert.equal(colourOf("failed"), "bad");
  assert.deepEqual(engines.flatMap(notesOf), ["it was killed"]);
});

test("whatever is missing is left out", () => {
  assert.deepEqual(statusWords({ state: "starting", engines: [] }), ["starting"]);
  assert.deepEqual(statusWords({}), ["unknown"]);
  assert.deepEqual(timesOf({ name: "a", late: 2, latency_us: { p50: 1 } }), { latency_us: { p50: 1 }, late: 2 });
  assert.deepEqual(notesOf({}), []);
});

test("notes: restarts, baseline, what was refused, and no start", () => {
  const beside = { supervisor: { events: [[1, "started", "x"], [2, "ended", "signal 9"]] } };
  const notes = { tare: ["gain is a guess"], granted: { refused: ["no real-time priority"] } };
  assert.deepEqual(notesOf({ beside, notes }), ["ended: signal 9", "gain is a guess", "no real-time priority"]);
  const readings = { hexagon72: ["calibrate"] };
  assert.deepEqual(notesOf({ notes: { readings } }), ["hexagon72: calibrate"]);
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { chipOf, colourOf, headline, healthWords, notesOf, timesOf } from "../src/status.js";

const engine = (more = {}) => ({
  name: "a",
  state: "running",
  rate: 999.7,
  since_start: { late: 4 },
  lately: { latency_us: { p50: 182, p99: 1530, count: 9 }, late: 1, cycles: 1000 },
  ...more,
});
const said = (more = {}, unread = {}) => headline({ state: "running", engines: [engine(more)] }, unread);

test("a running engine is good; its numbers are in Health", () => {
  assert.deepEqual(said(), { state: "good", text: "Good" });
  const page = { updates_per_s: 30, bytes_per_s: 2000, clients: 3 };
  const words = healthWords({ engines: [engine()], page });
  assert.equal(words[0], "latency 182 µs, p99 1.53 ms");
  assert.match(words[1], /^30 updates\/s/);
  assert.equal(words[2], "2 others look on");
});

test("what is wrong is one phrase, the worst first", () => {
  assert.deepEqual(said({}, { unread_s: 1.24, fades_s: 0.5 }), { state: "bad", text: "No reading for 1.2 s" });
  assert.equal(said({}, { unread_s: 0.4, fades_s: 0.5 }).text, "Good");
  assert.equal(said({ notes: { failed: "ContactFit cannot be prepared" } }).text, "Linear answers only");
  assert.equal(said({ lately: { late: 120, cycles: 1000 } }).text, "12 % of the estimates are late");
  assert.equal(said({ sources_lately: { udp: { received: 90, lost: 10 } } }).text, "10 % of the messages are lost");
  assert.equal(headline({ state: "failed", engines: [engine({ state: "failed" })] }).text, "The engine has ended");
  assert.equal(headline({ state: "calibrating" }).state, "waiting");
  assert.equal(headline({ state: "paused", engines: [engine({ state: "paused" })] }).text, "Paused");
  assert.equal(headline({}).state, "bad");
});

test("old readings: which patch, and how old", () => {
  const palm = { name: "palm", stale: false, age: 0.01 };
  const thumb = { name: "thumb", stale: true, age: 3.04 };
  const index = { name: "index", stale: true, age: 0.2 };
  assert.deepEqual(said({ patches: [palm, index, thumb] }), { state: "bad", text: "thumb and 1 more: no reading for 3.0 s" });
  assert.deepEqual(said({ patches: [palm, index] }), { state: "waiting", text: "index: no reading for 0.2 s" });
  assert.equal(said({ patches: [thumb] }).text, "No reading for 3.0 s");
  assert.equal(said({ patches: [palm, { name: "tip", stale: true, age: null }] }).text, "tip: no reading yet");
});

test("answers that are not what was asked for, while time is short", () => {
  const palm = { name: "palm", answer: "linear", stale: true, age: 0.7 };
  const short = { patches: [palm], notes: { searching: { palm: 4 } } };
  assert.deepEqual(said(short, { unread_s: 0.7, fades_s: 0.5 }), { state: "waiting", text: "Linear answer for 4 s: no time to search" });
  const both = { patches: [{ ...palm, answer: "contacts" }, { name: "tip" }], notes: { searching: { tip: 2, palm: 12 } } };
  assert.equal(said(both).text, "palm and 1 more: search unfinished for 12 s");
  assert.equal(said({ lately: { latency_us: { p50: 2.5e5, count: 9 } } }).text, "Estimates are 0.3 s behind the skin");
  const preparing = { what: "compiling", done: 0.2, seconds_left: 9 };
  assert.equal(headline({ state: "running", engines: [engine()], preparing }).text, "Linear answers until the skin is prepared");
});

test("one of three is gone: said, and not averaged away", () => {
  const gone = { name: "c", state: "failed", viewer_notes: ["it was killed"] };
  const engines = [engine(), engine({ name: "b" }), gone];
  assert.equal(headline({ state: "mixed", engines }).text, "2 of 3 engines run");
  assert.equal(colourOf("mixed"), "waiting");
  assert.equal(colourOf("failed"), "bad");
  assert.deepEqual(engines.flatMap(notesOf), ["it was killed"]);
});

test("whatever is missing is left out", () => {
  assert.deepEqual(healthWords({}), []);
  assert.deepEqual(timesOf({ name: "a", late: 2, latency_us: { p50: 1 } }), { latency_us: { p50: 1 }, late: 2 });
  assert.deepEqual(notesOf({}), []);
  assert.deepEqual(notesOf({ error: "no answer", viewer_notes: ["calibrate", ""] }), ["no answer", "calibrate"]);
});

test("the chip says what is looked at", () => {
  assert.equal(chipOf({ mode: "live", press: {} }), "simulated");
  assert.equal(chipOf({ mode: "live", press: null }), "live");
  assert.equal(chipOf({ mode: "remote" }), "live");
  assert.equal(chipOf({ mode: "replay", press: null }), "recording");
});

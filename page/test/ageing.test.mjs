import assert from "node:assert/strict";
import { test } from "node:test";

const text = { textContent: "" };
globalThis.document = { getElementById: () => text };
const timers = [];
globalThis.setInterval = (call) => timers.push(call);
const { Ageing, ageOf, fadeOf, seenWords } = await import("../src/ageing.js");
const { solverOptions } = await import("../src/controls.js");

function made(rows = []) {
  const style = { setProperty: () => {} };
  const scene = { drawn: 0, redraw: () => (scene.drawn += 1), container: { dataset: {}, style } };
  const said = [];
  return { scene, said, ageing: new Ageing({ rows: () => rows, scene, unread: (of) => said.push(of) }) };
}

const contact = (more = {}) => ({ key: "a 1", seen_s: 0.02, seen_ms: 1e12, fades_s: 0.5, old: false, ...more });
const head = (contacts, more = {}) => ({ contacts, stamp_ns: 1e18, age_s: 0.02, fades_s: 0.5, old: false, ...more });

let greyed = false;
function row() {
  return { dataset: { key: "a 1" }, style: { setProperty: () => {} }, classList: { toggle: (_, on) => (greyed = on) } };
}

test("a contact ages by the page's own clock when the server is silent", () => {
  const one = row();
  const { ageing, scene, said } = made([one]);
  ageing.update(head([contact()]), 1000);
  ageing.drawn(1010);
  ageing.look(1100);
  assert.equal(one.dataset.ageMs, "120");
  assert.equal(scene.container.dataset.fade, undefined);
  assert.equal(text.textContent, "");
  ageing.look(2000);
  assert.equal(one.dataset.ageMs, "1020");
  assert.equal(greyed, true);
  assert.equal(scene.container.dataset.fade, "1.00");
  assert.equal(text.textContent, "last seen 1.0 s ago");
  assert.ok(said.at(-1).unread_s > 0.9);
  assert.ok(scene.drawn > 0);
});

test("a stamp that stands still ages, whatever the server says of it", () => {
  const shown = [];
  const { ageing } = made();
  for (let now = 0; now <= 2000; now += 100) {
    shown.push(ageing.update(head([contact({ seen_s: 0.01 })]), now).contacts[0]);
  }
  assert.equal(shown.at(-1).age_ms, 2000);
  assert.equal(shown.at(-1).old, true);
  const [next] = ageing.update(head([contact({ seen_s: 0.01, seen_ms: 1e12 + 2000 })]), 2100).contacts;
  assert.equal(next.age_ms, 10);
  assert.equal(next.fade, 0);
});

test("what an ended engine saw is grey at once; a recording does not age", () => {
  const { ageing, scene } = made();
  const [last] = ageing.update(head([contact({ old: true })], { old: true }), 0).contacts;
  ageing.look(0);
  assert.equal(last.fade, 1);
  assert.equal(scene.container.dataset.fade, "1.00");
  ageing.passes(false);
  const [recorded] = ageing.update(head([contact({ seen_s: 0.02 })]), 0).contacts;
  ageing.look(60000);
  assert.equal(recorded.age_ms, 20);
  assert.equal(recorded.fade, 0);
  assert.equal(scene.container.dataset.fade, "");
});

test("what was told does not age: a look back shows it as it was, and what is new ages from when it came", () => {
  const { ageing } = made();
  const told = head([contact()]);
  const [shown] = ageing.update(told, 0).contacts;
  ageing.look(9000);
  assert.equal(shown.fade, 1);
  ageing.passes(false);
  const [past] = ageing.update(told, 9000).contacts;
  ageing.look(9500);
  assert.deepEqual([past.fade, past.old, told.contacts[0].old], [0, false, false]);
  ageing.passes(true);
  const [again] = ageing.update(told, 0).contacts;
  ageing.look(9600);
  assert.deepEqual([again.fade, again.age_ms], [1, 9620]);
});

test("ages, fades and words", () => {
  assert.equal(ageOf({ seen_s: null }, 1, 2), Infinity);
  assert.deepEqual([0, 250, 375, 500, 9000].map((age) => fadeOf(age, 0.5)), [0, 0, 0.5, 1, 1]);
  assert.equal(seenWords(312), "last seen 0.3 s ago");
  assert.equal(seenWords(31200), "last seen 31 s ago");
  assert.equal(seenWords(Infinity), "not of now");
});

test("solvers come in two groups, those to use first", () => {
  const all = ["auto", "gaussian", "nonnegative", "tikhonov", "pseudo-inverse", "inverse", "contact", "other"];
  const found = solverOptions(all.map((name) => [name, name]));
  assert.deepEqual(found.filter(([, , group]) => group === "Use").map(([value]) => value), ["auto", "contact", "nonnegative"]);
  assert.deepEqual([...found.map(([value]) => value)].sort(), [...all].sort());
  assert.equal(found.at(-1)[2], "Study");
});

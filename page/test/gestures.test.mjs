import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { PressGestures } from "../src/gestures.js";

let sent;
let gestures;
const tool = { shape: "ball", radius: 0.004, force: 2 };
const at = (time, more = {}) => ({ patch: 0, position: [0.01, 0.02, 0], id: null, x: 100, y: 100, shift: false, time, ...more });
const words = () => sent.map(({ do: what, id }) => `${what} ${id}`);

beforeEach(() => {
  sent = [];
  gestures = new PressGestures((command) => sent.push(command), () => ({ ...tool }), "p");
});

function click(time, more) {
  gestures.down(at(time, more));
  gestures.up(at(time + 0.1, more));
}

test("a click presses and stays", () => {
  click(0);
  assert.deepEqual(sent, [{ do: "press", id: "p1", patch: 0, position: [0.01, 0.02, 0], ...tool }]);
  assert.deepEqual(gestures.ids, ["p1"]);
});

test("a press that is refused is not moved or lifted any more", async () => {
  gestures = new PressGestures((command) => (sent.push(command), Promise.resolve(command.do !== "press")), () => ({ ...tool }), "p");
  click(0);
  await Promise.resolve();
  await Promise.resolve();
  assert.deepEqual(gestures.ids, []);
  gestures.setForce(3);
  click(1);
  assert.deepEqual(words(), ["press p1", "press p2"]);
});

test("presses that are asked for are missing until they press", () => {
  click(0);
  assert.deepEqual(gestures.missing([]), [{ id: "p1", position: [0.01, 0.02, 0] }]);
  assert.deepEqual(gestures.missing(["7-p1"]), []);
});

test("a hold lifts on release", () => {
  gestures.down(at(0));
  gestures.up(at(0.5));
  assert.deepEqual(words(), ["press p1", "lift p1"]);
});

test("a drag moves, and lifts on release however quick it was", () => {
  gestures.down(at(0));
  gestures.move(at(0.1, { x: 120, position: [0.02, 0, 0] }));
  gestures.up(at(0.2, { x: 120 }));
  assert.deepEqual(words(), ["press p1", "move p1", "lift p1"]);
  assert.deepEqual(sent[1].position, [0.02, 0, 0]);
});

test("with Alt a drag pushes along the skin, and the press stays where it is", () => {
  gestures.friction = 0.5;
  gestures.down(at(0, { alt: true }));
  gestures.move(at(0.1, { x: 120, position: [0.015, 0.02, 0] }));
  gestures.move(at(0.2, { x: 220, position: [0.01, 0.07, 0] }));
  const [near, far] = sent.slice(1);
  assert.deepEqual([near.position, far.position], [[0.01, 0.02, 0], [0.01, 0.02, 0]]);
  near.shear.forEach((value, axis) => assert.ok(Math.abs(value - [0.5, 0, 0][axis]) < 1e-9)); // half of 1 N
  far.shear.forEach((value, axis) => assert.ok(Math.abs(value - [0, 1, 0][axis]) < 1e-9));
});

test("a tremble is no drag", () => {
  gestures.down(at(0));
  gestures.move(at(0.1, { x: 103, position: [0.011, 0.02, 0] }));
  gestures.up(at(0.2, { x: 103 }));
  assert.deepEqual(words(), ["press p1"]);
});

test("moves are sent at a bounded rate, the last one always", () => {
  gestures.down(at(0));
  for (let i = 1; i <= 1000; i += 1) gestures.move(at(i / 1000, { x: 100 + i, position: [i, 0, 0] }));
  gestures.up(at(1.001));
  const moves = sent.filter((command) => command.do === "move");
  assert.ok(moves.length > 20 && moves.length < 45, `${moves.length}`);
  assert.deepEqual(moves.at(-1).position, [1000, 0, 0]);
  assert.equal(sent.at(-1).do, "lift");
});

test("off the skin the press stays where it was last", () => {
  gestures.down(at(0));
  gestures.move(at(0.1, { x: 150, position: null }));
  assert.deepEqual(words(), ["press p1"]);
  gestures.up(at(0.2));
  assert.deepEqual(words(), ["press p1", "lift p1"]);
});

test("a new press replaces what stands, with Shift it joins", () => {
  click(0);
  click(1, { shift: true });
  assert.deepEqual(gestures.ids, ["p1", "p2"]);
  click(2);
  assert.deepEqual(words(), ["press p1", "press p2", "lift p1", "lift p2", "press p3"]);
  assert.deepEqual(gestures.ids, ["p3"]);
});

test("a standing press can be taken elsewhere and stays there", () => {
  click(0);
  gestures.down(at(1, { id: "p1" }));
  gestures.move(at(1.2, { id: "p1", x: 130, position: [0.03, 0, 0] }));
  gestures.up(at(2, { id: "p1" }));
  assert.deepEqual(words(), ["press p1", "move p1"]);
  assert.deepEqual(gestures.ids, ["p1"]);
});

test("Shift and a click on a standing press lift it, a click alone does not", () => {
  click(0);
  click(1, { id: "p1" });
  assert.deepEqual(gestures.ids, ["p1"]);
  click(2, { id: "p1", shift: true });
  assert.deepEqual(words(), ["press p1", "lift p1"]);
});

test("what is not its own is pressed beside, not grabbed", () => {
  click(0, { id: "somebody's" });
  assert.deepEqual(words(), ["press p1"]);
});

test("a gesture that is taken away lifts what it began and leaves what stood", () => {
  click(0);
  gestures.down(at(1, { shift: true }));
  gestures.cancel(at(1.1));
  assert.deepEqual(gestures.ids, ["p1"]);
  gestures.down(at(2, { id: "p1" }));
  gestures.cancel(at(2.1));
  gestures.up(at(2.2));
  assert.deepEqual(words(), ["press p1", "press p2", "lift p2"]);
});

test("the force of the panel goes to the newest press", () => {
  gestures.setForce(3);
  click(0);
  gestures.setForce(3);
  assert.deepEqual(sent.at(-1), { do: "move", id: "p1", patch: 0, position: [0.01, 0.02, 0], force: 3 });
});

test("lift all lifts also what others pressed; after a new connection nothing is known", () => {
  click(0);
  gestures.liftAll();
  assert.deepEqual(sent.at(-1), { do: "lift", id: null });
  click(1);
  gestures.forget();
  sent.length = 0;
  click(2);
  assert.deepEqual(words(), ["press p3"]);
});

test("a press without a pointer stays", () => {
  gestures.tap({ patch: 1, position: [0, 0, 0] });
  assert.deepEqual(gestures.ids, ["p1"]);
  assert.equal(gestures.holding, false);
});

test("any order of events ends without a held press and with what was sent", () => {
  let seed = 7;
  const random = () => (seed = (1103515245 * seed + 12345) % 2147483648) / 2147483648;
  const there = new Set(); // what a server would know
  gestures = new PressGestures(({ do: what, id }) => {
    if (what === "press") there.add(id);
    if (what === "move") assert.ok(there.has(id));
    if (what === "lift" && id === null) there.clear();
    else if (what === "lift") assert.ok(there.delete(id));
  }, () => tool);
  for (let i = 0; i < 5000; i += 1) {
    const id = [null, ...there, "x"][Math.floor((there.size + 2) * random())];
    const event = at(i * 0.07 * random() + i, { id, x: 40 * random(), shift: random() < 0.5, position: random() < 0.2 ? null : [i, 0, 0] });
    const what = ["down", "move", "up", "cancel", "liftAll", "setForce"][Math.floor(6 * random())];
    if (what === "down") event.position ??= [0, 0, 0];
    if (what === "setForce") gestures.setForce(random());
    else gestures[what](event);
    assert.deepEqual([...there].sort(), [...gestures.ids].sort());
  }
});

test("keys move the newest press, from where it stands on the skin", () => {
  assert.equal(gestures.newest, null);
  click(0);
  click(1, { shift: true, position: [0.03, 0, 0] });
  assert.equal(gestures.newest.id, "p2");
  gestures.settle("p2", 0, [0.03, 0, 0.001]);
  assert.deepEqual(gestures.newest.position, [0.03, 0, 0.001]);
  gestures.shift("p2", 0, [0.031, 0, 0.001]);
  assert.deepEqual(sent.at(-1), { do: "move", id: "p2", patch: 0, position: [0.031, 0, 0.001] });
  gestures.shift("p9", 0, [0, 0, 0]); // that is gone
  assert.equal(words().at(-1), "move p2");
  gestures.liftMine();
  assert.equal(gestures.newest, null);
});

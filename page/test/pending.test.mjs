import assert from "node:assert/strict";
import { test } from "node:test";
import { Pending } from "../src/pending.js";

/** Answers that come when the test says so. */
function later() {
  let answer;
  const promise = new Promise((resolve) => (answer = resolve));
  return { promise, answer };
}

const watched = (patience = 5) => {
  const back = [];
  return { back, pending: new Pending((what) => back.push(what), patience) };
};

test("what is asked holds through news until the answer, and the first news after it ends it", async () => {
  const { pending, back } = watched();
  const { promise, answer } = later();
  const done = pending.wait("solver", promise);
  pending.settled();
  assert.ok(pending.has("solver"));
  assert.ok(!pending.has("resolution"));
  answer(true);
  assert.equal(await done, true);
  assert.ok(pending.has("solver"));
  pending.settled();
  assert.ok(!pending.has("solver"));
  await new Promise((resolve) => setTimeout(resolve, 20));
  assert.deepEqual(back, []);
});

test("a refusal goes back at once", async () => {
  const { pending, back } = watched();
  assert.equal(await pending.wait("solver", Promise.resolve(false)), false);
  assert.deepEqual(back, ["solver"]);
  assert.ok(!pending.has("solver"));
});

test("where nothing is told after the answer it goes back by itself", async () => {
  const { pending, back } = watched();
  await pending.wait("deadline_us", Promise.resolve(true));
  while (pending.has("deadline_us")) await new Promise((resolve) => setTimeout(resolve, 5));
  assert.deepEqual(back, ["deadline_us"]);
});

test("of two the newer counts, whatever becomes of the older", async () => {
  for (const first of [true, false]) {
    const { pending, back } = watched();
    const [one, other] = [later(), later()];
    const done = [pending.wait("solver", one.promise), pending.wait("solver", other.promise)];
    one.answer(first);
    await done[0];
    pending.settled();
    assert.ok(pending.has("solver"));
    other.answer(true);
    await done[1];
    pending.settled();
    assert.ok(!pending.has("solver"));
    assert.deepEqual(back, []);
  }
});

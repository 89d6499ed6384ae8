import assert from "node:assert/strict";
import { test } from "node:test";
import { Asked } from "../src/asked.js";

/** Answers that come when the test says so. */
function later() {
  let answer;
  const promise = new Promise((resolve) => (answer = resolve));
  return { promise, answer };
}

const watched = (patience = 5) => {
  const back = [];
  return { back, asked: new Asked((what) => back.push(what), patience) };
};

test("what is asked holds through news until the answer, and the first news after it ends it", async () => {
  const { asked, back } = watched();
  const { promise, answer } = later();
  const done = asked.wait("solver", promise);
  asked.told();
  assert.ok(asked.has("solver"));
  assert.ok(!asked.has("resolution"));
  answer(true);
  assert.equal(await done, true);
  assert.ok(asked.has("solver"));
  asked.told();
  assert.ok(!asked.has("solver"));
  await new Promise((resolve) => setTimeout(resolve, 20));
  assert.deepEqual(back, []);
});

test("a refusal goes back at once", async () => {
  const { asked, back } = watched();
  assert.equal(await asked.wait("solver", Promise.resolve(false)), false);
  assert.deepEqual(back, ["solver"]);
  assert.ok(!asked.has("solver"));
});

test("where nothing is told after the answer it goes back by itself", async () => {
  const { asked, back } = watched();
  await asked.wait("deadline_us", Promise.resolve(true));
  while (asked.has("deadline_us")) await new Promise((resolve) => setTimeout(resolve, 5));
  assert.deepEqual(back, ["deadline_us"]);
});

test("of two the newer counts, whatever becomes of the older", async () => {
  for (const first of [true, false]) {
    const { asked, back } = watched();
    const [one, other] = [later(), later()];
    const done = [asked.wait("solver", one.promise), asked.wait("solver", other.promise)];
    one.answer(first);
    await done[0];
    asked.told();
    assert.ok(asked.has("solver"));
    other.answer(true);
    await done[1];
    asked.told();
    assert.ok(!asked.has("solver"));
    assert.deepEqual(back, []);
  }
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { preparingWords } from "../src/preparing.js";

test("what is compiled says how long it takes", () => {
  assert.equal(preparingWords({ what: "compiling", done: 0.4, seconds_left: 12.3 }), "Compiling once for this machine, 12 s left");
  assert.equal(preparingWords({ what: "compiling", done: 0, seconds_left: 150 }), "Compiling once for this machine, 3 min left");
  assert.equal(preparingWords({ what: "preparing", done: 0.5, seconds_left: null }), "Preparing the skin");
  assert.equal(preparingWords({ what: "preparing", done: 0.99, seconds_left: 0.2 }), "Preparing the skin, 1 s left");
});

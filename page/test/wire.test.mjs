import assert from "node:assert/strict";
import { test } from "node:test";
import { checkGeometry, checkUpdate, decode, WireError } from "../src/wire.js";

const SIZES = { u8: 1, u16: 2, u32: 4, f32: 4 };

/** Pack a message byte by byte, from the wire's description and not with its code. */
function packed(head, parts = []) {
  const arrays = [];
  const payload = [];
  for (const [name, type, values] of parts) {
    arrays.push({ name, type, at: payload.length, length: values.length });
    const view = new DataView(new ArrayBuffer(values.length * SIZES[type]));
    values.forEach((value, i) => {
      if (type === "u8") view.setUint8(i, value);
      if (type === "u16") view.setUint16(2 * i, value, true);
      if (type === "u32") view.setUint32(4 * i, value, true);
      if (type === "f32") view.setFloat32(4 * i, value, true);
    });
    payload.push(...new Uint8Array(view.buffer));
    while (payload.length % 4) payload.push(0);
  }
  const text = new TextEncoder().encode(JSON.stringify({ ...head, arrays }));
  const padded = Math.ceil((8 + text.length) / 8) * 8;
  const out = new Uint8Array(padded + payload.length).fill(0x20);
  out.set([0x53, 0x4b, 0x46, 0x31]);
  new DataView(out.buffer).setUint32(4, padded - 8, true);
  out.set(text, 8);
  out.set(payload, padded);
  return out.buffer;
}

const update = (more = {}, parts = []) => packed({ kind: "update", number: 7, ...more }, parts);
const place = { patch: 0, position: [0, 0, 0], normal: [0, 0, 1], force: 1 };

test("arrays come back by place and by name", () => {
  const { head, arrays } = decode(
    update({ note: "µ" }, [
      ["a", "u8", [0, 255, 3]],
      ["b", "u16", [1, 65535]],
      ["c", "u32", [4294967295]],
      ["d", "f32", [-1.5, 0.25]],
    ]),
  );
  assert.equal(head.note, "µ");
  assert.deepEqual(arrays.map((array) => [...array]), [[0, 255, 3], [1, 65535], [4294967295], [-1.5, 0.25]]);
  assert.equal(arrays.byName.c, arrays[2]);
});

test("each broken message is refused with a WireError", () => {
  const whole = new Uint8Array(update({}, [["a", "f32", [1, 2, 3]]]));
  for (let end = 0; end < whole.length; end += 1) {
    assert.throws(() => decode(whole.slice(0, end).buffer), WireError, `cut at ${end}`);
  }
  const broken = [
    packed({ kind: 3 }),
    new TextEncoder().encode("SKF2....").buffer,
    "text",
    null,
  ];
  for (const entry of [
    { name: "a", type: "f64", at: 0, length: 1 },
    { name: "a", type: "u8", at: -4, length: 1 },
    { name: "a", type: "u8", at: 2, length: 1 },
    { name: "a", type: "u8", at: 0, length: 1e300 },
    { name: "a", type: "u8", at: 0, length: 0.5 },
    { name: "a", type: "toString", at: 0, length: 0 },
    { type: "u8", at: 0, length: 0 },
    null,
  ]) {
    const text = new TextEncoder().encode(JSON.stringify({ kind: "update", number: 1, arrays: [entry] }).padEnd(120));
    const out = new Uint8Array(8 + 120);
    out.set([0x53, 0x4b, 0x46, 0x31, 120, 0, 0, 0]);
    out.set(text, 8);
    broken.push(out.buffer);
  }
  for (const message of broken) assert.throws(() => decode(message), WireError);
});

test("random bytes never do anything but a WireError", () => {
  let seed = 12345;
  const random = () => (seed = (1103515245 * seed + 12345) % 2147483648) / 2147483648;
  const good = new Uint8Array(
    update({ patches: [{ i: 0, colour: 0 }], contacts: [place], truth: [] }, [["colour", "u16", [1, 2, 3, 4]]]),
  );
  let passed = 0;
  for (let round = 0; round < 20000; round += 1) {
    const bytes = round % 2 ? good.slice() : Uint8Array.from({ length: 64 * random() }, () => 256 * random());
    const hits = 1 + 4 * random();
    if (round % 2) for (let i = 0; i < hits; i += 1) bytes[Math.floor(bytes.length * random())] = 256 * random();
    try {
      const message = decode(bytes.buffer);
      checkUpdate(message);
      checkGeometry(message);
      passed += 1;
    } catch (error) {
      assert.ok(error instanceof WireError, `${error.stack}`);
    }
  }
  assert.ok(passed < 20000);
});

test("an update has its lists, and what they name is there", () => {
  const { head } = checkUpdate(decode(update()));
  assert.deepEqual([head.patches, head.contacts, head.truth], [[], [], []]);
  const colour = [["colour", "u16", [1, 2]]];
  assert.equal(checkUpdate(decode(update({ patches: [{ i: 0, colour: 0 }] }, colour))).head.patches[0].height, -1);
  for (const bad of [
    { number: -1 },
    { patches: [{ i: 0, colour: 1 }] },
    { patches: [{ i: 0, taxels: 0 }] },
    { patches: [{ i: 0, colour: 0.5 }] },
    { patches: [null] },
    { patches: { length: 1 } },
    { contacts: [{ ...place, position: [0, 0] }] },
    { contacts: [{ ...place, position: [0, 0, null] }] },
    { contacts: [{ ...place, force: "1" }] },
    { contacts: [{ ...place, outline: [[0, 0]] }] },
    { contacts: [{ ...place, shear: { size: 1, angle: 0, vector: [0, 1] } }] },
    { truth: [{ ...place, shear: { size: null, angle: 0, vector: [0, 1, 0] } }] },
    { truth: [{ ...place, patch: -1 }] },
  ]) {
    assert.throws(() => checkUpdate(decode(update(bad, colour))), WireError, JSON.stringify(bad));
  }
});

test("an image of a contact has all its pressures, or it is refused", () => {
  const image = { patch: 0, track: 1, rows: 1, columns: 2, cell: 8e-4, pose: [0, 0, 0], low: [0, 0], peak: 1e4, force: 1, area: 1e-6, readings: 3, outline: [[[0, 0], [1, 0]]], pressure: btoa("\u0000\u00ff") };
  const shapes = (more) => decode(update({ shapes: { why: "", images: [{ ...image, ...more }] } }));
  assert.deepEqual([...checkUpdate(shapes({})).head.shapes.images[0].bytes], [0, 255]);
  for (const bad of [{ rows: 2 }, { pressure: "?" }, { pressure: null }, { cell: 0 }, { outline: [[[0]]] }, { pose: [0, 0] }, { area: null }, { low: 0 }]) {
    assert.throws(() => checkUpdate(shapes(bad)), WireError, JSON.stringify(bad));
  }
  assert.throws(() => checkUpdate(decode(update({ shapes: [] }))), WireError);
});

test("a geometry has all nodes, or it is refused", () => {
  const make = (nodes, more = []) =>
    decode(
      packed({ kind: "geometry", patch: 0, rung: 2, rows: 2, columns: 2 }, [
        ["positions", "f32", Array(3 * nodes).fill(0)],
        ["normals", "f32", Array(3 * nodes).fill(0)],
        ["plane", "f32", Array(2 * nodes).fill(0)],
        ["covered", "u8", Array(nodes).fill(1)],
        ...more,
      ]),
    );
  assert.equal(checkGeometry(make(4)).head.rung, 2);
  assert.throws(() => checkGeometry(make(3)), WireError);
  assert.throws(() => checkGeometry(make(4, [["taxels", "f32", [0, 0, 0]]])), WireError);
});

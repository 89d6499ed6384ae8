import assert from "node:assert/strict";
import { afterEach, beforeEach, mock, test } from "node:test";

globalThis.location = new URL("http://robot:8700/?token=secret#x");
const { PageSocket, Refused } = await import("../src/socket.js");

let sockets;
let status; // that the server answers; 0: it is not there
let heard;

class FakeSocket {
  static OPEN = 1;
  constructor(address) {
    this.address = String(address);
    this.readyState = 0;
    this.sent = [];
    sockets.push(this);
  }
  send(text) {
    this.sent.push(JSON.parse(text));
  }
  close(code = 1006, reason = "") {
    if (this.readyState === 3) return;
    this.readyState = 3;
    this.onclose({ code, reason });
  }
  accept() {
    this.readyState = 1;
    this.onopen();
  }
  say(message) {
    this.onmessage({ data: JSON.stringify(message) });
  }
}

const real = { WebSocket: globalThis.WebSocket, fetch: globalThis.fetch };
const settle = async () => {
  for (let i = 0; i < 20; i += 1) await Promise.resolve();
};

/** Let so many ms go by, and what waits for them happen. */
async function pass(ms) {
  for (let gone = 0; gone < ms; gone += 50) {
    mock.timers.tick(50);
    await settle();
  }
}

beforeEach(() => {
  [sockets, status, heard] = [[], 200, []];
  globalThis.WebSocket = FakeSocket;
  globalThis.fetch = async (address) => {
    heard.push(`asked ${address.pathname}${address.search}`);
    if (!status) throw new TypeError("refused");
    return { status };
  };
  mock.timers.enable({ apis: ["setTimeout", "setInterval"] });
});

afterEach(() => {
  mock.timers.reset();
  Object.assign(globalThis, real);
});

function made() {
  const socket = new PageSocket({
    onOpen: () => heard.push("open"),
    onLost: (why) => heard.push(`lost${why}`),
    onRefused: (why, said = "") => heard.push(`refused ${why} ${said}`.trim()),
    onText: (message) => heard.push(message?.kind ?? "nothing"),
    onBinary: (data) => heard.push(`bytes ${data.byteLength}`),
  });
  socket.connect();
  return socket;
}

test("the token of the address goes to the socket", () => {
  made();
  assert.equal(sockets[0].address, "ws://robot:8700/socket?token=secret");
});

test("answers come to whoever asked, whatever their order", async () => {
  const socket = made();
  sockets[0].accept();
  const [first, second] = [socket.ask({ do: "tare" }), socket.ask({ do: "set" })];
  const [a, b] = sockets[0].sent.map(({ tag }) => tag);
  sockets[0].say({ kind: "answer", tag: b, ok: false, error: "no" });
  sockets[0].say({ kind: "answer", tag: a, ok: true, more: 1 });
  sockets[0].say({ kind: "answer", tag: 99, ok: true });
  assert.equal((await first).more, 1);
  await assert.rejects(second, new Refused("no"));
});

test("text that is no JSON, and bytes, are handed on", () => {
  made();
  sockets[0].accept();
  sockets[0].onmessage({ data: "{" });
  sockets[0].onmessage({ data: new ArrayBuffer(3) });
  assert.deepEqual(heard, ["open", "nothing", "bytes 3"]);
});

test("after a loss it looks for the server, and connects when it is back", async () => {
  const socket = made();
  sockets[0].accept();
  const asked = socket.ask({ do: "tare" });
  status = 0;
  sockets[0].close();
  await assert.rejects(asked, Refused);
  await assert.rejects(socket.ask({ do: "tare" }), Refused);
  await pass(10000);
  assert.equal(sockets.length, 1, "no socket without a server");
  const looks = heard.filter((what) => what === "asked /api/status?token=secret").length;
  assert.ok(looks >= 5 && looks <= 9, `${looks} looks in 10 s`);
  status = 200;
  await pass(2100);
  assert.equal(sockets.length, 2);
  sockets[1].accept();
  assert.ok(socket.open);
});

test("without the token it says so and stops", async () => {
  made();
  status = 401;
  sockets[0].close();
  await pass(5000);
  assert.equal(heard.at(-1), "refused token");
  assert.equal(sockets.length, 1);
});

test("where no place is free it says so, and comes in once there is one", async () => {
  made();
  sockets[0].accept();
  sockets[0].close(1013, "16 browsers look on already");
  assert.equal(heard.at(-1), "refused full 16 browsers look on already");
  await pass(1000);
  assert.equal(sockets.length, 2);
  sockets[1].accept();
  assert.equal(heard.at(-1), "open");
});

test("a page that lost its place by silence says why", () => {
  made();
  sockets[0].accept();
  sockets[0].close(4008, "nothing was drawn");
  assert.equal(heard.at(-1), "lostnothing was drawn");
});

test("a line without a word for long is given up", async () => {
  made();
  sockets[0].accept();
  await pass(14000);
  sockets[0].say({ kind: "status" });
  await pass(14000);
  assert.equal(sockets.length, 1);
  await pass(2000);
  assert.equal(heard.includes("lost"), true);
  assert.equal(sockets.length, 2);
});

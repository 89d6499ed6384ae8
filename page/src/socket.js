// The connection to the server: comes back by itself, and pairs answers with what was asked.

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 2000;
const PATIENCE_MS = 5000; // with a server that is busy
const FULL = 1013; // codes with which the server ends a connection: no place is free,
const HUNG = 4008; // or this page was silent for too long
const SILENT_S = 15; // without a word the line is dead: the server tells its status twice a second

/** A command that was refused, or whose connection went away; its text says why. */
export class Refused extends Error {}

export class PageSocket {
  #handlers;
  #token = new URLSearchParams(location.search).get("token");
  #socket = null;
  #asked = new Map(); // tag -> {resolve, reject}
  #tag = 0;
  #wait = FIRST_WAIT_MS;
  #timer = null;
  #silent = 0; // s, counted in turns of the loop: a page that was held up has not been left alone
  #watch = null;

  /** @param {{onText, onBinary, onOpen, onLost, onRefused}} handlers */
  constructor(handlers) {
    this.#handlers = handlers;
  }

  /** Is there a connection? */
  get open() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Connect, and again whenever the connection is lost. */
  connect() {
    clearTimeout(this.#timer);
    const socket = new WebSocket(this.#address("socket", location.protocol.replace("http", "ws")));
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.#opened();
    socket.onmessage = ({ data }) => this.#message(data);
    socket.onclose = ({ code, reason }) => this.#lost(socket, code, reason);
    clearInterval(this.#watch);
    this.#silent = 0;
    this.#watch = setInterval(() => this.#look(socket), 1000);
  }

  /** Make the connection anew. */
  restart() {
    this.#socket?.close();
  }

  /** Send a command; nothing is sent without a connection. */
  send(command) {
    if (this.open) this.#socket.send(JSON.stringify(command));
  }

  /** Send a command; resolves with its answer. @throws {Refused} */
  ask(command) {
    if (!this.open) return Promise.reject(new Refused("there is no connection"));
    const tag = ++this.#tag;
    return new Promise((resolve, reject) => {
      this.#asked.set(tag, { resolve, reject });
      this.send({ ...command, tag });
    });
  }

  #address(path, protocol = location.protocol) {
    const address = new URL(path, location.href);
    address.protocol = protocol;
    address.search = address.hash = "";
    if (this.#token !== null) address.searchParams.set("token", this.#token);
    return address;
  }

  #opened() {
    this.#wait = FIRST_WAIT_MS;
    this.#silent = 0;
    this.#handlers.onOpen();
  }

  #message(data) {
    this.#silent = 0;
    if (typeof data !== "string") return this.#handlers.onBinary(data);
    let message;
    try {
      message = JSON.parse(data);
    } catch {
      message = null;
    }
    if (message?.kind === "answer") this.#answer(message);
    else this.#handlers.onText(message);
  }

  #answer(message) {
    const asked = this.#asked.get(message.tag);
    this.#asked.delete(message.tag);
    if (!asked) return;
    if (message.ok) asked.resolve(message);
    else asked.reject(new Refused(String(message.error ?? "the server refused, without a reason")));
  }

  #look(socket) {
    this.#silent += 1;
    if (socket !== this.#socket || this.#silent < SILENT_S) return;
    this.#lost(socket); // close() alone waits for the other end, which may be gone
    socket.close();
  }

  #lost(socket, code = 0, reason = "") {
    if (socket !== this.#socket) return;
    this.#socket = null;
    clearInterval(this.#watch);
    for (const { reject } of this.#asked.values()) reject(new Refused("the connection was lost"));
    this.#asked.clear();
    if (code === FULL) this.#handlers.onRefused("full", reason);
    else this.#handlers.onLost(code === HUNG ? reason : "");
    this.#again();
  }

  /** Connect again once the server is there; a socket itself does not tell why it was refused. */
  #again() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(async () => {
      const status = await this.#statusThere();
      if (status === 401 || status === 403) this.#handlers.onRefused("token");
      else if (status === 0) this.#again();
      else this.connect();
    }, this.#wait);
    this.#wait = Math.min(2 * this.#wait, LONGEST_WAIT_MS);
  }

  /** HTTP status of the server; 0 where there is none. */
  async #statusThere() {
    try {
      const signal = AbortSignal.timeout(PATIENCE_MS);
      return (await fetch(this.#address("api/status"), { cache: "no-store", signal })).status;
    } catch {
      return 0;
    }
  }
}

// The status line at the top, and the panel of the engines' health.
import { byId, element, setText } from "./dom.js";
import { bytes, count, fixed, micros } from "./format.js";

const GOOD = new Set(["running", "live", "playing", "paused"]);
const WAITING = new Set(["starting", "calibrating", "connecting", "mixed"]);
const NO_ANSWERS = new Set(["starting", "calibrating"]); // cycles there are, but no estimates
const MOST_NOTES = 6;

const REPLAYED = new Set(["playing", "paused"]); // of a recording that is shown by itself

/** good, waiting or bad: what colour a state has. */
export function colourOf(state) {
  if (GOOD.has(state)) return "good";
  return WAITING.has(state) ? "waiting" : "bad";
}

const LATE = 0.05; // of the estimates, from which on it is said
const LOST = 0.02; // of the messages
const BEHIND_US = 1e5; // from a reading to its estimate, half of them at least

/** One phrase about all engines: good, or what is wrong; what can be done is in the notes. */
export function headline(status, { unread_s = 0, fades_s = 0.5 } = {}) {
  const engines = status.engines ?? [];
  const gone = engines.filter((each) => colourOf(each.state) === "bad").length;
  if (status.state === "mixed") return { state: "waiting", text: `${engines.length - gone} of ${engines.length} engines run` };
  const state = colourOf(status.state);
  if (state === "bad") return { state, text: status.state === "failed" ? "The engine has ended" : `The engine is ${status.state ?? "unknown"}` };
  if (status.state === "starting") return { state, text: "The engine starts" };
  if (status.state === "calibrating") return { state, text: "Taking the baseline: leave the skin untouched" };
  if (state === "waiting") return { state, text: status.state };
  const searching = engines.flatMap(searchesOf);
  if (unread_s > fades_s && !searching.length) return { state: "bad", text: `No reading for ${secondsOf(unread_s)}` };
  const silent = silence(engines, searching);
  if (silent) return { state: silent.age <= fades_s ? "waiting" : "bad", text: silent.text };
  const failed = engines.map((each) => each.notes?.failed).find(Boolean);
  if (failed) return { state: "waiting", text: "Linear answers only" };
  if (status.preparing) return { state: "waiting", text: "Linear answers until the skin is prepared" };
  if (searching.length) return { state: "waiting", text: searchWords(engines, searching) };
  const behind = worst(engines, (each) => timesOf(each).latency_us?.p50);
  if (behind > BEHIND_US) return { state: "waiting", text: `Estimates are ${secondsOf(behind / 1e6)} behind the skin` };
  const share = worst(engines, ({ lately }) => (lately?.late ?? 0) / Math.max(lately?.cycles ?? 0, 1));
  if (share > LATE) return { state: "waiting", text: `${fixed(100 * share, 0)} % of the estimates are late` };
  const lost = worst(engines, lostShare);
  if (lost > LOST) return { state: "waiting", text: `${fixed(100 * lost, 0)} % of the messages are lost` };
  return { state: "good", text: REPLAYED.has(status.state) ? capital(status.state) : "Good" };
}

function secondsOf(seconds) {
  return `${fixed(seconds, seconds < 10 ? 1 : 0)} s`;
}

/** Searches that find no end: whose, for how long, and whether there was no time to begin. */
function searchesOf({ notes, patches }) {
  const linear = new Set((patches ?? []).filter(({ answer }) => answer === "linear").map(({ name }) => name));
  return Object.entries(notes?.searching ?? {}).map(([name, seconds]) => ({ name, seconds, linear: linear.has(name) }));
}

function searchWords(engines, searching) {
  searching.sort((one, other) => other.seconds - one.seconds);
  const [{ seconds, linear }] = searching;
  const what = linear ? `linear answer for ${seconds} s: no time to search` : `search unfinished for ${seconds} s`;
  return told(engines, searching, what);
}

/** Patches without a new reading: which, and how long; not those whose search takes that long. */
function silence(engines, searching) {
  const busy = new Set(searching.map(({ name }) => name));
  const ageOf = ({ age }) => age ?? Infinity;
  const stale = engines.flatMap((each) => each.patches ?? []).filter(({ stale, name }) => stale && !busy.has(name));
  if (!stale.length) return null;
  stale.sort((one, other) => ageOf(other) - ageOf(one));
  const age = ageOf(stale[0]);
  return { age, text: told(engines, stale, age < Infinity ? `no reading for ${secondsOf(age)}` : "no reading yet") };
}

/** Whose it is, the worst first, where there are several; then what it is. */
function told(engines, named, what) {
  if (engines.flatMap((each) => each.patches ?? []).length < 2) return capital(what);
  const others = named.length - 1;
  return `${named[0].name}${others ? ` and ${others} more` : ""}: ${what}`;
}

function worst(engines, share) {
  return Math.max(0, ...engines.map(share).filter(Number.isFinite));
}

function lostShare({ sources_lately: sources }) {
  const all = Object.values(sources ?? {});
  const sum = (name) => all.reduce((total, each) => total + (each[name] ?? 0), 0);
  const lost = sum("lost") + sum("overflowed");
  return lost / Math.max(lost + sum("received"), 1);
}

function capital(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** What the header needs no number of. */
export function healthWords(status) {
  const engines = status.engines ?? [];
  const known = engines.map((each) => timesOf(each).latency_us).filter((times) => times?.count !== 0);
  const highest = (key) => Math.max(...known.map((times) => times?.[key]).filter(Number.isFinite));
  const { updates_per_s: updates, bytes_per_s: sent, clients } = status.page ?? status;
  const parts = [];
  if (Number.isFinite(highest("p50"))) parts.push(`latency ${micros(highest("p50"))}, p99 ${micros(highest("p99"))}`);
  if (Number.isFinite(updates)) parts.push(`${fixed(updates, 0)} updates/s, ${bytes(sent)}/s`);
  const others = (clients ?? 1) - 1;
  if (others > 0) parts.push(`${others} other${others > 1 ? "s" : ""} look${others > 1 ? "" : "s"} on`);
  return parts;
}

/** Simulated, live, or a recording. */
export function chipOf({ mode, press }) {
  if (mode === "replay") return "recording";
  return press ? "simulated" : "live";
}

/** What an engine tells of its times lately. */
export function timesOf(engine) {
  const { late = engine.late } = engine.since_start ?? {};
  return { latency_us: engine.latency_us ?? engine.lately?.latency_us, late };
}

export class StatusLine {
  #line = byId("status-line");
  #lost = false;
  #mode = "live";

  #status = null;
  #unread = {};

  /** There is a connection, or why there is none. */
  connection(text) {
    this.#lost = text !== null;
    document.body.classList.toggle("lost", this.#lost);
    byId("main").inert = this.#lost;
    if (this.#lost) this.#say("waiting", text);
  }

  /** The server does not let this page in. */
  refused(why, chip) {
    this.connection(why);
    setText(byId("mode"), chip);
  }

  hello(message) {
    const { mode, name } = message;
    this.#mode = mode;
    this.#status = null; // of what was looked at before
    setText(byId("mode"), chipOf(message));
    byId("mode").dataset.mode = chipOf(message);
    byId("mode").title = mode === "remote" ? "A skin elsewhere: this page only looks on" : "";
    setText(byId("skin-name"), name ?? "");
    byId("skin-name").title = name ?? "";
    document.title = name ? `${name} · skinfield` : "skinfield";
  }

  show(status) {
    this.#status = status;
    if (this.#lost) return;
    this.#headline();
    const words = healthWords(status).map((each) => each.replaceAll(" ", "\u00a0")).join(" · "); // numbers beside their units
    setText(byId("health-text"), words);
    this.#showEngines(status.engines ?? []);
    this.#showNotes((status.engines ?? []).flatMap(notesOf));
  }

  /** How long no reading has come, which is seen before the server tells its status. */
  unread(unread) {
    this.#unread = unread;
    if (this.#status && !this.#lost) this.#headline();
  }

  #headline() {
    const { state, text } = headline(this.#status, this.#unread);
    const other = this.#mode === "replay" && !REPLAYED.has(this.#status.state) && this.#status.engines?.length;
    this.#say(state, other ? `Live skin: ${text}` : text);
  }

  #say(state, text) {
    this.#line.dataset.state = state;
    setText(this.#line.querySelector(".status-text"), text);
    this.#line.title = text;
  }

  #showEngines(engines) {
    const rows = engines.map((each) => {
      const state = element("td", { class: `state ${colourOf(each.state)}`, text: each.state });
      return element(
        "tr",
        { "data-engine": each.name },
        element("th", { scope: "row", text: each.name, title: each.name }),
        state,
        element("td", { class: "n", text: count(each.rate) }),
        element("td", { class: "n", text: fixed(timesOf(each).latency_us?.p99, 0) }),
        element("td", { class: "n", text: count(timesOf(each).late) }),
      );
    });
    byId("engines").tBodies[0].replaceChildren(...rows);
  }

  #showNotes(notes) {
    const texts = [...new Set(notes)].slice(0, MOST_NOTES);
    const key = texts.join("\n");
    if (byId("notes").dataset.key === key) return;
    byId("notes").dataset.key = key;
    byId("notes").replaceChildren(...texts.map((text) => element("li", { text })));
  }
}

/** What somebody can do something about; the server has left out the rest. */
export function notesOf({ error, viewer_notes: notes }) {
  return [error, ...(notes ?? [])].filter((text) => typeof text === "string" && text !== "");
}

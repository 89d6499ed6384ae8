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

/** One sentence about all engines. */
export function statusWords(status) {
  const engines = status.engines ?? [];
  const gone = engines.filter((each) => colourOf(each.state) === "bad").length;
  const rate = engines.reduce((sum, each) => sum + (each.rate || 0), 0) / Math.max(engines.length - gone, 1);
  const late = engines.reduce((sum, each) => sum + (timesOf(each).late ?? 0), 0);
  const known = engines.map((each) => timesOf(each).latency_us).filter((times) => times?.count !== 0);
  const worst = (key) => Math.max(...known.map((times) => times?.[key]).filter(Number.isFinite));
  const some = `${engines.length - gone} of ${engines.length} engines run`;
  const parts = [status.state === "mixed" ? some : (status.state ?? "unknown")];
  if (engines.length > 1 && status.state !== "mixed") parts.push(`${engines.length} engines`);
  if (rate > 0 && !NO_ANSWERS.has(status.state)) parts.push(`${count(rate)} estimates/s`);
  if (Number.isFinite(worst("p50"))) parts.push(`latency ${micros(worst("p50"))}, p99 ${micros(worst("p99"))}`);
  if (late > 0) parts.push(`${count(late)} late`);
  return parts;
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

  /** There is a connection, or why there is none. */
  connection(text) {
    this.#lost = text !== null;
    document.body.classList.toggle("lost", this.#lost);
    byId("main").inert = this.#lost;
    if (this.#lost) this.#say("waiting", [text]);
  }

  /** The server does not let this page in. */
  refused() {
    this.connection("this page needs its token");
    setText(byId("mode"), "locked");
  }

  hello({ mode, name }) {
    this.#mode = mode;
    setText(byId("mode"), mode === "replay" ? "recording" : mode === "remote" ? "remote" : "live");
    byId("mode").dataset.mode = mode;
    setText(byId("skin-name"), name ?? "");
    byId("skin-name").title = name ?? "";
    document.title = name ? `${name} · skinfield` : "skinfield";
  }

  show(status) {
    if (this.#lost) return;
    const { updates_per_s: updates, bytes_per_s: sent, clients } = status.page ?? status;
    const page = `${fixed(updates, 0)} updates/s, ${bytes(sent)}/s`;
    const words = statusWords(status);
    if (this.#mode === "replay" && status.engines?.length && !REPLAYED.has(status.state)) words[0] = `live skin ${words[0]}`;
    this.#say(colourOf(status.state), words, page);
    this.#showEngines(status.engines ?? []);
    this.#showNotes((status.engines ?? []).flatMap(notesOf));
    const others = (clients ?? 1) - 1;
    setText(byId("health-text"), others > 0 ? `${page} · ${others} other${others > 1 ? "s" : ""}` : page);
  }

  #say(state, parts, more = "") {
    this.#line.dataset.state = state;
    setText(this.#line.querySelector(".status-text"), parts.join(" · "));
    this.#line.title = [...parts, more].filter(Boolean).join("\n");
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

/** What somebody should know of an engine: failures, what its readings are like, its baseline ... */
export function notesOf({ error, notes, beside }) {
  const events = (beside?.supervisor?.events ?? []).filter(([, kind]) => kind !== "started").slice(-3);
  const readings = Object.entries(notes?.readings ?? {});
  const said = Array.isArray(notes)
    ? notes
    : [
        notes?.failed,
        ...readings.flatMap(([patch, texts]) => texts.map((text) => `${patch}: ${text}`)),
        ...(notes?.tare ?? []),
        ...(notes?.granted?.refused ?? []),
      ];
  const told = [error, ...said];
  return [...events.map((event) => event.slice(1).join(": ")), ...told].filter(
    (text) => typeof text === "string" && text !== "",
  );
}

// Age of what is shown: contacts and fields fade as their reading gets older.
// The server tells how old a reading was when it sent it; what has passed since then is counted here,
// so that clocks of two machines need not agree, and nothing stays bright when the server is silent.

import { byId, setText } from "./dom.js";

const LOOK_MS = 100;

/**
 * How old a reading is, ms, however the server's word of it may be.
 * @param {{seen_s: ?number, seen_ms: number}} contact
 * @param {number} since ms since it was told
 * @param {number} known ms since its stamp was first heard of
 */
export function ageOf(contact, since, known) {
  return Math.max(Number.isFinite(contact.seen_s) ? 1e3 * contact.seen_s + since : Infinity, known);
}

/** 0: of now, 1: not of now any more. Half of the time it stays as it is. */
export function fadeOf(age_ms, fades_s) {
  return Math.min(Math.max(age_ms / (500 * fades_s) - 1, 0), 1);
}

/** "last seen 0.3 s ago". */
export function seenWords(age_ms) {
  if (!Number.isFinite(age_ms)) return "not of now";
  const seconds = age_ms / 1e3;
  return `last seen ${seconds < 10 ? seconds.toFixed(1) : Math.round(seconds)} s ago`;
}

export class Ageing {
  #head = null;
  #at = 0; // ms, when it came
  #drawn = 0; // ms, when it was on the screen: until then the server is not asked for more
  #known = new Map(); // key of a contact -> {stamp, at}: when its stamp was first heard of
  #passes = true;
  #rows;
  #scene;
  #unread;

  /**
   * @param {{rows: () => Iterable<HTMLElement>, scene: object, unread: (of: object) => void}} shown
   */
  constructor({ rows, scene, unread }) {
    this.#rows = rows;
    this.#scene = scene;
    this.#unread = unread;
    setInterval(() => this.look(), LOOK_MS);
  }

  /** Does time pass for what is shown? Not for a recording, nor for a moment of the past. */
  passes(passes) {
    this.#passes = passes;
    this.#head = null;
    this.#known.clear();
    this.look();
  }

  /**
   * An update has come; its contacts learn their ages before they are drawn.
   * @returns {object} the same with contacts of its own, which age; what was told stays as it is
   */
  update(told, now = performance.now()) {
    const head = { ...told, contacts: told.contacts.map((each) => ({ ...each })) };
    this.#head = head;
    this.#at = now;
    this.#drawn = Infinity;
    const known = new Map();
    for (const { key, seen_ms: stamp } of head.contacts) {
      const before = this.#known.get(key);
      known.set(key, before?.stamp === stamp ? before : { stamp, at: now });
    }
    this.#known = known;
    this.#age(now);
    return head;
  }

  /** The update is on the screen. */
  drawn(now = performance.now()) {
    this.#drawn = now;
  }

  #age(now) {
    const head = this.#head;
    const since = this.#passes ? now - this.#at : 0;
    let grown = false;
    for (const contact of head.contacts) {
      const known = this.#passes ? now - this.#known.get(contact.key).at : 0;
      const age = ageOf(contact, since, known);
      const old = contact.old || (this.#passes && age > 1e3 * contact.fades_s);
      grown ||= old && (!contact.old || seenWords(age) !== contact.seen);
      Object.assign(contact, { age_ms: age, old, seen: seenWords(age) });
      contact.fade = old ? 1 : this.#passes ? fadeOf(age, contact.fades_s) : 0;
    }
    return grown;
  }

  /** Show the ages of now. */
  look(now = performance.now()) {
    const head = this.#head;
    if (!head) return this.#dim(0);
    if (this.#age(now)) this.#scene.redraw();
    const shown = new Map(head.contacts.map((contact) => [contact.key, contact]));
    for (const row of this.#rows()) showAge(row, shown.get(row.dataset.key));
    this.#say();
    const passes = this.#passes && head.stamp_ns > 0;
    const waited = Math.max(now - this.#drawn, 0);
    const unread = passes ? 1e3 * head.age_s + waited : 0;
    const fades_s = head.fades_s ?? 0.5;
    const ended = head.old && (head.stamp_ns > 0 || head.contacts.length > 0);
    this.#dim(ended ? 1 : fadeOf(unread, fades_s));
    this.#unread({ unread_s: unread / 1e3, fades_s });
  }

  /** In the table's caption: when the oldest of what fades was seen. */
  #say() {
    const fading = this.#head.contacts.filter(({ fade }) => fade > 0);
    const oldest = fading.sort((one, other) => other.age_ms - one.age_ms)[0];
    setText(byId("contacts-seen"), oldest ? oldest.seen : "");
  }

  #dim(fade) {
    const { container } = this.#scene;
    const text = fade > 0 ? fade.toFixed(2) : "";
    if ((container.dataset.fade ?? "") === text) return;
    container.dataset.fade = text;
    container.style.setProperty("--fade", text || "0");
  }
}

/** A row says how old its reading is, and fades with it. */
function showAge(row, contact) {
  if (!contact) return;
  const { age_ms, fade, old } = contact;
  row.dataset.ageMs = Number.isFinite(age_ms) ? String(Math.round(age_ms)) : "";
  row.classList.toggle("old", Boolean(old));
  row.style.setProperty("--fade", fade.toFixed(2));
  row.title = fade > 0 ? contact.seen : "";
}

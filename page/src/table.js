// The accessible table of the contacts, with the truth beside them where it is known.
import { byId, element, setText } from "./dom.js";
import { contactWords, fixed, forceUnit, forceWords, orElse, shearWords } from "./format.js";
import { unfound } from "./truth_match.js";

const SAY_EVERY_S = 4; // a reader of the screen is told no more often than this

export class ContactsTable {
  #table = byId("contacts-table");
  #body = this.#table.tBodies[0];
  #said = { at: -Infinity, count: -1 };

  /**
   * Show contacts matched with presses.
   * @param {Array} rows of truth_match.matched
   * @param {Array} truths
   * @param {{now: number, patchName: (i) => string, slotOf: (track) => number, none: string, relative: boolean}} of
   *   the page; none: what to say where there is no contact; relative: forces hold up to one factor
   */
  show(rows, truths, { now, patchName, slotOf, none, relative }) {
    const missed = unfound(rows, truths);
    const made = [
      ...rows.toSorted(byNumber).map((row) => contactRow(row, patchName, slotOf)),
      ...missed.map((truth) => missedRow(truth, patchName)),
    ];
    if (made.length === 0) made.push(emptyRow(none));
    this.#table.classList.toggle("has-shear", rows.some(({ contact, truth }) => contact.shear || truth?.shear));
    this.#body.replaceChildren(...made);
    this.#say(rows, now, relative);
  }

  /** Show nothing. */
  clear() {
    this.#body.replaceChildren(emptyRow());
    setText(byId("contacts-total"), "");
  }

  #say(rows, now, relative) {
    const total = rows.reduce((sum, { contact }) => sum + contact.force, 0);
    setText(byId("contacts-total"), rows.length ? `${rows.length} · ${fixed(total, 2)} ${forceUnit(relative)} in all` : "");
    const { at, count } = this.#said;
    if (now - at < SAY_EVERY_S || (rows.length === count && rows.length === 0)) return;
    this.#said = { at: now, count: rows.length };
    const each = rows.slice(0, 4).map(({ contact }) => `${fixed(contact.force, 1)} ${relative ? "relative" : "newtons"} at ${place(contact)} millimetres${contact.maybe ? `, perhaps ${orElse(contact.maybe)}` : ""}`);
    const words = rows.length ? `${rows.length} contact${rows.length > 1 ? "s" : ""}: ${each.join("; ")}` : "No contact";
    setText(byId("contacts-summary"), words);
  }
}

/** Rows stay in their places when one contact grows stronger than another. */
function byNumber({ contact: one }, { contact: other }) {
  return one.patch - other.patch || one.track - other.track;
}

function contactRow({ contact, truth, error_m, error_percent }, patchName, slotOf) {
  const row = element(
    "tr",
    { ...dataOf(contact, truth, error_m, error_percent), class: contact.old ? "old" : null },
    element("th", { scope: "row", title: contactWords(contact) }, swatch(slotOf(contact.key)), ` ${contact.track}`, orTwo(contact)),
    element("td", { text: patchName(contact.patch), title: patchName(contact.patch), class: "patch" }),
    element("td", { class: "n", text: place(contact) }),
    element("td", { class: "n", text: forceWords(contact) }),
    shearCell(contact),
    element("td", { class: "n area", text: fixed(1e6 * contact.area, 0) }),
    element("td", { class: "n truth", text: truth ? fixed(truth.force, 2) : "" }),
    element("td", { class: "n truth", text: truth ? fixed(1e3 * error_m, 1) : "" }),
    element("td", { class: "n truth", text: truth ? signed(error_percent) : "" }),
  );
  row.style.setProperty("--fade", fixed(contact.fade ?? 0, 2));
  return row;
}

/** The force along the skin, with an arrow by the plane's x and y; empty where none is known. */
function shearCell({ shear }) {
  if (!shear) return element("td", { class: "n along" });
  const arrow = element("i", { "aria-hidden": "true", text: "→" });
  arrow.style.rotate = `${fixed(-degrees(shear), 0).replace("−", "-")}deg`;
  return element("td", { class: "n along", title: shearWords(shear) }, arrow, ` ${fixed(shear.size, 2)}`);
}

function dataOf(contact, truth, error_m, error_percent) {
  const { shear } = contact;
  const data = {
    "data-track": contact.track,
    "data-key": contact.key,
    "data-age-ms": number(contact.age_ms, 0),
    "data-patch": contact.patch,
    "data-x-mm": number(1e3 * contact.x, 3),
    "data-y-mm": number(1e3 * contact.y, 3),
    "data-force": number(contact.force, 4),
    "data-force-std": number(contact.force_std, 4),
    "data-area-mm2": number(1e6 * contact.area, 2),
    "data-shear": shear ? number(shear.size, 4) : null,
    "data-shear-std": shear ? number(shear.std, 4) : null,
    "data-shear-degrees": shear ? number(degrees(shear), 1) : null,
    "data-shape": contact.shape,
    "data-maybe": contact.maybe || null,
  };
  if (!truth) return data;
  return {
    ...data,
    "data-truth-force": number(truth.force, 4),
    "data-truth-x-mm": number(1e3 * truth.x, 3),
    "data-truth-y-mm": number(1e3 * truth.y, 3),
    "data-truth-shear": truth.shear ? number(truth.shear.size, 4) : null,
    "data-error-mm": number(1e3 * error_m, 3),
    "data-error-percent": number(Math.abs(error_percent), 2),
  };
}

/** A press that was not found, or not yet. */
function missedRow(truth, patchName) {
  return element(
    "tr",
    { class: "missed", "data-missed": truth.id },
    element("th", { scope: "row", text: "–" }),
    element("td", { text: patchName(truth.patch), class: "patch" }),
    element("td", { class: "n", text: place(truth) }),
    element("td", { class: "n", text: "not found" }),
    element("td", { class: "n along" }),
    element("td", { class: "area" }),
    element("td", { class: "n truth", text: fixed(truth.force, 2) }),
    element("td", { class: "truth", colspan: "2" }),
  );
}

function emptyRow(text = "No contact") {
  return element("tr", { class: "empty" }, element("td", { colspan: "9", text }));
}

function swatch(slot) {
  const mark = element("i", { class: "swatch", "aria-hidden": "true" });
  if (slot >= 0) mark.style.background = `var(--slot-${slot})`;
  return mark;
}

/** A contact that may be two, or one of two that may be one, says so. */
function orTwo({ maybe }) {
  return maybe ? element("small", { class: "or-two", text: ` · ${orElse(maybe)}?` }) : null;
}

function degrees({ angle }) {
  return (180 * angle) / Math.PI;
}

function place({ x, y }) {
  return `${fixed(1e3 * x, 1)}, ${fixed(1e3 * y, 1)}`;
}

function signed(value) {
  return value > 0 ? `+${fixed(value, 0)}` : fixed(value, 0);
}

function number(value, places) {
  return Number.isFinite(value) ? Number(value.toFixed(places)) : null;
}

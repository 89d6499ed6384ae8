// What the user should know: in a corner, read aloud, to be put away.
import { byId, element } from "./dom.js";

const MOST = 4;
const STAYS_MS = { info: 6000, warn: 10000, error: 15000 };

const open = new Map(); // text -> {item, times, timer}

/** Show a notice; the same text again counts up in its place. */
export function notice(level, text) {
  const kind = level in STAYS_MS ? level : "info";
  const there = open.get(text) ?? add(kind, text);
  there.times += 1;
  there.item.querySelector(".times").textContent = there.times > 1 ? `×${there.times}` : "";
  clearTimeout(there.timer);
  there.timer = setTimeout(() => dismiss(text), STAYS_MS[kind]);
  while (open.size > MOST) dismiss(open.keys().next().value);
}

/** Put a notice away. */
export function dismiss(text) {
  const there = open.get(text);
  if (!there) return;
  clearTimeout(there.timer);
  there.item.remove();
  open.delete(text);
}

function add(level, text) {
  const close = element("button", { type: "button", class: "quiet", "aria-label": "Dismiss", text: "✕" });
  const item = element(
    "div",
    { class: `notice ${level}`, role: level === "error" ? "alert" : null },
    element("p", {}, element("span", { text }), element("span", { class: "times" })),
    close,
  );
  close.addEventListener("click", () => dismiss(text));
  byId("notices").append(item);
  const entry = { item, times: 0, timer: null };
  open.set(text, entry);
  return entry;
}

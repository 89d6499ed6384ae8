// Keys that work wherever the focus is, except where they mean something to the focused control.

const TURN = 0.12; // rad per key press
const NEARER = 1.14; // per key press
const STEP_M = 1e-3; // that a press moves per key press
const FAR_M = 5e-3; // with Shift
const HARDER_N = 0.1;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const TURNS = { a: [-TURN, 0], d: [TURN, 0], w: [0, -TURN], s: [0, TURN] };
const QUANTITIES = ["pressure", "deformation", "uncertainty", "taxels"];

/**
 * @param {object} does orbit(dx, dy), zoom(factor), home(), quantity(name), tare(), record(), play(),
 *   step(readings), loop(), lift(), press(), help(); shift(right, up), m, and harder(newtons) of the
 *   newest press: false where none stands, and the picture turns or comes nearer instead
 */
export function startKeyboard(does) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (document.querySelector("dialog[open]")) return;
    const action = actionOf(event, does);
    if (!action || belongsTo(event.target, event.key)) return;
    event.preventDefault();
    action();
  });
}

function actionOf({ key, repeat, shiftKey }, does) {
  const letter = key.length === 1 ? key.toLowerCase() : key;
  if (key in ARROWS) return () => arrow(ARROWS[key], shiftKey ? FAR_M : STEP_M, does);
  if (key === "+" || key === "=") return () => does.harder(HARDER_N) || does.zoom(NEARER);
  if (key === "-" || key === "−") return () => does.harder(-HARDER_N) || does.zoom(1 / NEARER);
  if (letter in TURNS) return () => does.orbit(...TURNS[letter]);
  if (letter === "e" || letter === "q") return () => does.zoom(letter === "e" ? NEARER : 1 / NEARER);
  if (key === "." || key === ",") return () => does.step(key === "." ? 1 : -1);
  if (repeat) return null;
  const named = QUANTITIES[Number(key) - 1];
  if (named && key.length === 1) return () => does.quantity(named);
  const once = { Home: "home", Escape: "lift", "?": "help", " ": "play", t: "tare", r: "record", p: "press", l: "loop" };
  const name = once[letter];
  return name ? () => does[name]() : null;
}

/** Arrows move the newest press, or turn the picture where none stands. */
function arrow([right, up], metres, does) {
  if (!does.shift(right * metres, up * metres)) does.orbit(right * TURN, -up * TURN);
}

/** Does the focused control need this key itself? */
function belongsTo(target, key) {
  if (!(target instanceof Element) || key === "Escape") return false;
  if (target.matches("textarea, select, [contenteditable]")) return true;
  if (target.matches("input:not([type=checkbox], [type=range])")) return true;
  if (target.matches("input[type=range]")) return key in ARROWS || key === "Home";
  if (target.matches("[tabindex='0']") && target.scrollHeight > target.clientHeight) return key in ARROWS;
  return key === " " && target.matches("button, a, summary, input");
}

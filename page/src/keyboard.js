// Keys that work wherever the focus is, except where they mean something to the focused control.

const TURN = 0.12; // rad per key press
const NEARER = 1.14; // per key press
const ARROWS = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] };
const QUANTITIES = ["pressure", "deformation", "uncertainty", "taxels"];

/**
 * @param {object} does orbit(dx, dy), zoom(factor), home(), quantity(name), tare(), record(), play(),
 *   lift(), press(), help()
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

function actionOf({ key, repeat }, does) {
  if (key in ARROWS) return () => does.orbit(...ARROWS[key]);
  if (key === "+" || key === "=") return () => does.zoom(NEARER);
  if (key === "-" || key === "−") return () => does.zoom(1 / NEARER);
  if (repeat) return null;
  const named = QUANTITIES[Number(key) - 1];
  if (named && key.length === 1) return () => does.quantity(named);
  const once = { Home: "home", Escape: "lift", "?": "help", " ": "play", t: "tare", r: "record", p: "press" };
  const name = once[key.length === 1 ? key.toLowerCase() : key];
  return name ? () => does[name]() : null;
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

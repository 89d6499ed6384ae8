// The bar of what the engine prepares: how much is done, and how long it still takes.
import { byId, setText } from "./dom.js";

const MINUTE = 90; // s, from which on minutes are told

/** What is being prepared, in words. */
export function preparingWords({ what, seconds_left: left }) {
  const doing = what === "compiling" ? "Compiling once for this machine" : "Preparing the skin";
  if (!Number.isFinite(left)) return doing;
  const seconds = Math.max(Math.round(left), 1);
  return `${doing}, ${seconds > MINUTE ? `${Math.round(seconds / 60)} min` : `${seconds} s`} left`;
}

/** Show it, or nothing once there is nothing to wait for. */
export function showPreparing(preparing) {
  const box = byId("preparing");
  box.hidden = !preparing;
  if (!preparing) return;
  const percent = Math.round(100 * Math.min(Math.max(preparing.done, 0), 1));
  const words = preparingWords(preparing);
  setText(box.querySelector(".preparing-text"), words);
  box.setAttribute("aria-valuenow", percent);
  box.setAttribute("aria-valuetext", words);
  box.querySelector("i").style.width = `${percent}%`;
}

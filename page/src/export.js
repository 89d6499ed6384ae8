// What can be saved: the table of contacts, and the picture as it is seen.
import { byId } from "./dom.js";
import { cssColour } from "./theme.js";

const FOOT = 46; // px below the picture, for the colour bar and what is shown
const BAR = { width: 180, height: 10 }; // px
const FONT = '12px system-ui, "Segoe UI", Roboto, sans-serif';

/** Save a text as a file. */
export function saveText(name, text) {
  save(name, new Blob([text], { type: "text/csv;charset=utf-8" }));
}

function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name.replace(/[^\w.-]+/g, "_");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** Save the picture with its colour bar; `words` says what is shown. */
export function savePicture(name, scene, words) {
  scene.draw(); // what was drawn before is not kept by the browser
  const { width, height } = scene.canvas;
  const ratio = width / Math.max(scene.canvas.clientWidth, 1);
  const made = Object.assign(document.createElement("canvas"), { width, height: height + FOOT * ratio });
  const pen = made.getContext("2d");
  pen.fillStyle = cssColour("--panel");
  pen.fillRect(0, 0, made.width, made.height);
  pen.drawImage(scene.canvas, 0, 0);
  pen.scale(ratio, ratio);
  drawFoot(pen, height / ratio, scene.table.image.data, words);
  made.toBlob((blob) => blob && save(name, blob), "image/png");
}

/** Below the picture: its colour table, 256 times RGBA, with the ticks of the page's colour bar, and words. */
function drawFoot(pen, top, table, words) {
  for (let i = 0; i < 256; i += 1) {
    pen.fillStyle = `rgb(${table[4 * i]} ${table[4 * i + 1]} ${table[4 * i + 2]})`;
    pen.fillRect(12 + (i * BAR.width) / 256, top + 10, BAR.width / 256 + 0.6, BAR.height);
  }
  Object.assign(pen, { font: FONT, fillStyle: cssColour("--muted"), textBaseline: "top" });
  for (const tick of byId("colour-ticks").children) {
    const at = parseFloat(tick.style.left) / 100;
    pen.textAlign = at < 0.03 ? "left" : at > 0.97 ? "right" : "center";
    pen.fillText(tick.textContent, 12 + at * BAR.width, top + 25);
  }
  pen.textAlign = "left";
  pen.fillText(words[0], BAR.width + 28, top + 8);
  pen.fillText(words[1], BAR.width + 28, top + 25);
}

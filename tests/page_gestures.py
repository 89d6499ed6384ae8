"""What a hand does on the page's skin, in millimetres of its plane."""

from dataclasses import dataclass
from typing import Any

from browser import Look

NEAR = 4.0  # mm, of what the engine alone finds at once

PIXEL = """([x, y]) => {
  const { scene } = window.skinfield, box = scene.canvas.getBoundingClientRect();
  const middle = scene.pick(box.width / 2, box.height / 2);
  let at = { x: box.width / 2, y: box.height / 2 };
  for (let turn = 0; turn < 40; turn += 1) {  // towards the place that is meant
    const here = scene.pickAtRest(at.x, at.y);
    if (!here) return null;
    const [dx, dy] = [x - here.x, y - here.y];
    if (Math.hypot(dx, dy) < 2e-5) break;
    const step = 1.5;
    const right = scene.pickAtRest(at.x + step, at.y);
    const down = scene.pickAtRest(at.x, at.y + step);
    if (!right || !down) return null;
    const a = (right.x - here.x) / step, b = (down.x - here.x) / step;
    const c = (right.y - here.y) / step, d = (down.y - here.y) / step, det = a * d - b * c;
    at = { x: at.x + (d * dx - b * dy) / det, y: at.y + (a * dy - c * dx) / det };
  }
  const found = scene.pickAtRest(at.x, at.y);
  return { x: box.x + at.x, y: box.y + at.y, at: found && [found.x, found.y], middle };
}"""


LABELS = """() => {  // how many, and what of one covers another or the ellipse of a place
  const { scene } = skinfield, { marks } = scene;
  const cards = marks.labels.placed.filter(({ accent, hidden }) => accent && !hidden);
  const covered = [];
  cards.forEach((a, i) => cards.slice(i + 1).forEach((b) => {
    const apart = a.x + a.width <= b.x || b.x + b.width <= a.x
      || a.y + a.height <= b.y || b.y + b.height <= a.y;
    if (!apart) covered.push(["label", i]);
  }));
  for (const { patch, x, y, place_cov: [xx, xy, yy] } of marks.contacts) {
    const [half, det] = [(xx + yy) / 2, xx * yy - xy * xy], out = { position: [], normal: [] };
    const wide = Math.sqrt(4.605 * (half + Math.sqrt(half * half - det)));  // nine times in ten
    if (wide > 0.3 * marks.size) continue;
    for (let turn = 0; turn < 32; turn += 1) {  // Cholesky's square root, around the circle
      const [c, s] = [Math.cos(turn * Math.PI / 16), Math.sin(turn * Math.PI / 16)];
      const u = Math.sqrt(4.605 * xx) * c;
      const v = Math.sqrt(4.605 / xx) * (xy * c + Math.sqrt(det) * s);
      if (!scene.patches.at(patch, x + u, y + v, out, true)) continue;
      const at = scene.project(out.position);
      const within = ({ x, y, width, height }) =>
        at.x > x && at.x < x + width && at.y > y && at.y < y + height;
      if (cards.some(within)) {
        covered.push(["ellipse", turn]);
        break;
      }
    }
  }
  return [cards.length, covered];
}"""


NOTHING_LEFT = """(since) => {  // in three updates, one after the other
  const { updates, truth, contacts } = skinfield.state;
  if (truth.length || contacts.length) window.leftAt = updates;
  return updates - Math.max(window.leftAt ?? 0, since) >= 3;
}"""


@dataclass
class Hand:
    """The pointer on a page."""

    look: Look

    def pixel(self, x_mm: float, y_mm: float) -> tuple[float, float]:
        """Of the window, where a place of the skin is seen."""
        found: Any = self.look.value(PIXEL, [1e-3 * x_mm, 1e-3 * y_mm])
        assert found is not None, f"{x_mm}, {y_mm} mm is not in the picture"
        off = max(abs(1e3 * found["at"][0] - x_mm), abs(1e3 * found["at"][1] - y_mm))
        assert off < 0.1, (x_mm, y_mm, found)
        return found["x"], found["y"]

    def click(self, x_mm: float, y_mm: float) -> None:
        """Press quickly: it stays."""
        self.look.page.mouse.click(*self.pixel(x_mm, y_mm))

    def shift_click(self, x_mm: float, y_mm: float) -> None:
        """Press, and keep those that stand."""
        self.look.page.keyboard.down("Shift")
        self.click(x_mm, y_mm)
        self.look.page.keyboard.up("Shift")

    def lift(self) -> None:
        """Lift all, and wait until nothing is left."""
        self.look.page.keyboard.press("Escape")
        self.look.until(NOTHING_LEFT, self.look.value("skinfield.state.updates"))
        self.look.wait_rows(lambda rows: not rows)

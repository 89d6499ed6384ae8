"""Make the pictures of design-a-skin.md, and print the numbers that the page quotes."""

from pathlib import Path

import click
from click.testing import CliRunner
from PIL import Image

from skinfield.cli import main

IMAGES = Path(__file__).parent / "images"
CAPACITANCE = ("--noise", "0.002", "--radius", "1")
STRESS = ("--quantity", "stress", "--noise", "400", "--radius", "1")
PICTURES = {
    "design-capacitance-2mm": ("hexagon72", "--thickness", "2", *CAPACITANCE),
    "design-capacitance-4mm": ("hexagon72", "--thickness", "4", *CAPACITANCE),
    "design-stress-2mm": ("hexagon72", "--thickness", "2", *STRESS),
    "design-stress-4mm": ("hexagon72", "--thickness", "4", *STRESS),
    "design-thickness": ("hexagon72", "--compare-thickness", "1,2,3,4,5,6", *STRESS),
    "design-thickness-capacitance": (
        "hexagon72", "--compare-thickness", "1,2,3,4,5,6", *CAPACITANCE,
    ),
}  # fmt: skip


def draw() -> None:
    """All pictures, by the command that the page shows."""
    for name, words in PICTURES.items():
        file = IMAGES / f"{name}.png"
        result = CliRunner().invoke(main, ["design", *words, "-o", str(file)])
        if result.exit_code:
            raise SystemExit(result.output)
        with Image.open(file) as picture:
            picture.convert("RGB").quantize(128, dither=Image.Dither.NONE).save(file, optimize=True)
        click.echo(f"== {name}: skinfield design {' '.join(words)}\n{result.output}")


if __name__ == "__main__":
    draw()

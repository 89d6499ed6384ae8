"""Make the pictures of docs/how-to/design.md, and print the numbers that the page quotes."""

import subprocess
import sys
from pathlib import Path

import click
from PIL import Image

CODE = "from skinfield.cli import main; main()"
IMAGES = Path(__file__).parents[1] / "images"
CAPACITANCE = ("--noise", "0.002", "--radius-mm", "1")
PICTURES = {
    "design-capacitance-2mm": ("hexagon72", "--thickness-mm", "2", *CAPACITANCE),
    "design-capacitance-4mm": ("hexagon72", "--thickness-mm", "4", *CAPACITANCE),
}


def draw() -> None:
    """All pictures, by the command that the page shows."""
    for name, words in PICTURES.items():
        file = IMAGES / f"{name}.png"
        command = [sys.executable, "-c", CODE, "design", *words, "-o", str(file), "--force"]
        result = subprocess.run(command, check=True, capture_output=True, text=True)
        with Image.open(file) as picture:
            picture.convert("RGB").quantize(128, dither=Image.Dither.NONE).save(file, optimize=True)
        click.echo(f"== {name}: skinfield design {' '.join(words)}\n{result.stdout}")


if __name__ == "__main__":
    draw()

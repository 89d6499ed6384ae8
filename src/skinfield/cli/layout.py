"""`skinfield layout`: where the taxels are."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skinfield.cli.inputs import LAYOUT_HELP, skin_from_text
from skinfield.layout import Patch, Skin

if TYPE_CHECKING:
    from skinfield.layout.finding import Finding

COLOURS = {"error": "red", "warning": "yellow", "info": "cyan"}
MOST_ROWS = 6  # of a finding, named in the table


@click.group(
    context_settings={"max_content_width": 100},
    help="""Show, check and convert layouts: files that say where the taxels are.

Known files are skinfield's own .toml and .npz, Skinware calibration.cache, CySkin .json, iCub
positions .txt, skinGui .ini, point clouds .pcd and fingertip positions .txt. The content decides
which of them a file is, not its name.

\b
  skinfield layout lint torso.pcd
  skinfield layout show right_foot.txt -o foot.png
  skinfield layout convert right_foot.txt foot.toml
""",
)
def layout() -> None:
    """Layout files."""


@layout.command(
    short_help="Draw a layout to a picture.",
    help=f"""Draw a layout to a PNG, PDF or SVG file.

{LAYOUT_HELP}

A flat patch is drawn in its plane, pads to scale and coloured by module, over the triangulation;
a curved one in 3D from outside, with its normals as short arrows.

\b
  skinfield layout show hexagon72 -o hexagon.png
  skinfield layout show right_foot.txt -o foot.pdf
""",
)
@click.argument("text", metavar="LAYOUT")
@click.option("-o", "--output", required=True, help="Figure to write: .png, .pdf or .svg.")
def show(text: str, output: str) -> None:
    """Draw a layout."""
    from skinfield.figures.layout import draw_layout
    from skinfield.figures.save import check_name, save

    check_name(output)
    skin = skin_from_text(text)
    _say_notes(skin)
    save(draw_layout(skin), output)
    click.echo(f"wrote {output}: {_summary(skin)}")


@layout.command(
    short_help="List what is wrong with a layout.",
    help=f"""List what is wrong with a layout, what it means, and what reading it does.

{LAYOUT_HELP}

Exit code: 0 when nothing is wrong (warnings and remarks allowed), 1 when there is an error, 2 when
the file cannot be read. With --json, findings go to stdout as a list of objects with code,
severity, message and rows.

\b
  skinfield layout lint torso.pcd
  skinfield layout lint right_foot.txt --json
""",
)
@click.argument("text", metavar="LAYOUT")
@click.option("--json", "as_json", is_flag=True, help="Write the findings as JSON.")
@click.pass_context
def lint(ctx: click.Context, text: str, as_json: bool) -> None:
    """List what is wrong with a layout."""
    from skinfield.layout.lint import lint as lint_file
    from skinfield.layout.lint import lint_skin

    is_file = Path(text).is_file()
    findings = lint_file(text) if is_file else lint_skin(skin_from_text(text))
    if as_json:
        click.echo(json.dumps([asdict(found) for found in findings], indent=1))
    else:
        _print_findings(text, findings)
    ctx.exit(int(any(found.severity == "error" for found in findings)))


@layout.command(
    short_help="Convert a layout to another format.",
    help=f"""Convert a layout to another format, chosen by the extension of OUTPUT.

{LAYOUT_HELP}

Faults are repaired on the way; repairs, and what the format of OUTPUT cannot hold, are listed.
Formats that hold one patch take one: choose it with --patch.

\b
  skinfield layout convert right_foot.txt foot.toml
  skinfield layout convert hexagon72 calibration.cache
  skinfield layout convert tip.toml tip.txt --format fingertip
""",
)
@click.argument("text", metavar="LAYOUT")
@click.argument("output")
@click.option("--format", "name", help="Format of OUTPUT where its extension has several.")
@click.option("--patch", "patch", help="Name of the one patch to write.")
def convert(text: str, output: str, name: str | None, patch: str | None) -> None:
    """Convert a layout."""
    from skinfield.layout import save_layout
    from skinfield.layout.formats import format_by_name

    form = format_by_name(name) if name else None
    skin = skin_from_text(text)
    if patch is not None:
        skin = Skin((skin[patch],), name=skin.name, notes=skin.notes)
    lost = save_layout(skin, output, form)
    _say_notes(skin)
    for sentence in lost:
        click.echo(f"not kept: {sentence}", err=True)
    click.echo(f"wrote {output}: {_summary(skin)}")


@layout.command(
    short_help="Print the patches of a layout.",
    help=f"""Print the patches of a layout: taxels, modules, pitch, size, shape.

{LAYOUT_HELP}

\b
  skinfield layout info torso.pcd
""",
)
@click.argument("text", metavar="LAYOUT")
def info(text: str) -> None:
    """Print the patches of a layout."""
    skin = skin_from_text(text)
    click.echo(f"{skin.name}: {_summary(skin)}")
    for patch in skin:
        click.echo(_line(patch))
    _say_notes(skin)


@layout.command(
    short_help="List the layouts that need no file.",
    help="""List the layouts that need no file, with their arguments and defaults.

\b
  skinfield layout generators
  skinfield layout show cylinder:radius_mm=40 -o cylinder.png
""",
)
def generators() -> None:
    """List the layouts that need no file."""
    from skinfield.layout.generators.names import known

    for usage in known():
        click.echo(usage)


def _print_findings(title: str, findings: "list[Finding]") -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    if not findings:
        click.echo(f"{title}: nothing found")
        return
    click.echo(title)
    table = Table(show_lines=True)
    table.add_column("severity", no_wrap=True)
    table.add_column("code", no_wrap=True)
    table.add_column("what it means, and what reading the file does about it")
    table.add_column("rows", max_width=16)
    for found in findings:
        shown = ", ".join(map(str, found.rows[:MOST_ROWS]))
        rows = shown + (f", ... {len(found.rows)} in all" if len(found.rows) > MOST_ROWS else "")
        severity = Text(found.severity, style=COLOURS[found.severity])
        table.add_row(severity, found.code, Text(found.message), rows)  # names may hold brackets
    Console().print(table)
    counts = [f"{sum(f.severity == s for f in findings)} {s}" for s in COLOURS]
    click.echo(", ".join(counts))


def _line(patch: Patch) -> str:
    import numpy as np

    from skinfield.layout.normals import facing_from_positions, nearest_distance

    pitch: Any = np.median(nearest_distance(patch.positions)) * 1e3
    size = " x ".join(f"{side:.1f}" for side in np.ptp(patch.positions, axis=0) * 1e3)
    parts = [
        f"{len(patch)} taxels",
        f"{len(np.unique(patch.module))} modules",
        f"{patch.n_channels} channels",
        f"pitch {pitch:.2f} mm" if np.isfinite(pitch) else "a single place",
        f"pads {patch.pad_diameter * 1e3:.2f} mm",
        f"{size} mm",
        "flat" if facing_from_positions(patch.positions).is_flat else "curved",
        *([f"on {patch.link}"] if patch.link else []),
    ]
    return f"  {patch.name}: {', '.join(parts)}"


def _say_notes(skin: Skin) -> None:
    for note in skin.notes:
        click.echo(f"note: {note}", err=True)


def _summary(skin: Skin) -> str:
    taxels = sum(len(patch) for patch in skin)
    return f"{taxels} taxels in {len(skin)} patch{'es' if len(skin) > 1 else ''}"

"""`skinfield layout`: where the taxels are."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinfield.cli.main import new_app
from skinfield.cli.options import OUTPUT, Force, Json, LayoutWord, skin_from_text
from skinfield.cli.report import Shown, check_output, check_picture, finish, say_notes, table
from skinfield.skin import Patch, Skin

if TYPE_CHECKING:
    from skinfield.files.layouts.repair import Finding

COLOURS = {"error": "red", "warning": "yellow", "info": "cyan"}
MOST_ROWS = 6  # of a finding, named in the table

layout = new_app(
    "layout",
    """Show, check and convert layouts: files that say where the taxels are.

Known files are skinfield's own .toml and .npz, Skinware calibration.cache, CySkin .json, iCub
positions .txt, skinGui .ini, point clouds .pcd and fingertip positions .txt. The content decides
which of them a file is, not its name. LAYOUT is such a file, or a generator by name such as
hexagon72 or cylinder:radius_mm=40 ('skinfield layout generators' lists them).

  skinfield layout lint torso.pcd
  skinfield layout show right_foot.txt -o foot.png
  skinfield layout convert right_foot.txt foot.toml""",
)


@layout.command
def show(
    text: LayoutWord,
    /,
    *,
    output: Annotated[str, OUTPUT],
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw a layout to a PNG, PDF or SVG file.

    A flat patch is drawn in its plane, pads to scale and coloured by module, over the
    triangulation; a curved one in 3D from outside, with its normals as short arrows.

      skinfield layout show hexagon72 -o hexagon.png
      skinfield layout show right_foot.txt -o foot.pdf

    Parameters
    ----------
    output : str
        Figure to write: .png, .pdf or .svg.
    """
    from skinfield.plot import save
    from skinfield.skin.plot import draw_layout

    check_picture("--output", output, force)
    skin = skin_from_text(text)
    save(draw_layout(skin), output)
    _finish(skin, as_json, output)


@layout.command
def lint(text: LayoutWord, /, *, as_json: Json = False) -> int:
    """List what is wrong with a layout, what it means, and what reading it does.

    Exit code: 0 when nothing is wrong (warnings and remarks allowed), 1 when there is an error, 2
    when the file cannot be read.

      skinfield layout lint torso.pcd
      skinfield layout lint right_foot.txt --json
    """
    from skinfield.files.layouts.load import lint as lint_file

    skin_from_text(text)  # refuses what is no layout
    findings = lint_file(text) if Path(text).exists() else []  # of no generator
    finish(as_json, [asdict(each) for each in findings], lines=_finding_lines(text, findings))
    return int(any(finding.severity == "error" for finding in findings))


@layout.command
def convert(
    text: LayoutWord,
    output: Annotated[str, Parameter(name="OUTPUT")],
    /,
    *,
    patch: str | None = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Convert a layout to another format, chosen by the extension of OUTPUT.

    Faults are repaired on the way, and listed. Files are written in skinfield's own format, as text
    or as arrays.

      skinfield layout convert right_foot.txt foot.toml
      skinfield layout convert hexagon72 hexagon.toml

    Parameters
    ----------
    output : str
        File to write: .toml or .npz.
    patch : str, optional
        Name of the one patch to write.
    """
    from skinfield.files.layouts.load import save_layout

    check_output("OUTPUT", output, force)
    skin = skin_from_text(text)
    if patch is not None:
        skin = Skin((skin[patch],), name=skin.name, notes=skin.notes)
    save_layout(skin, output)
    _finish(skin, as_json, output)


@layout.command
def info(text: LayoutWord, /, *, as_json: Json = False) -> None:
    """Print the patches of a layout: taxels, modules, pitch, size, shape.

    LAYOUT is a file, or a generator by name.

      skinfield layout info torso.pcd
      skinfield layout info hexagon72 --json
    """
    _finish(skin_from_text(text), as_json)


def _finish(skin: Skin, as_json: bool, output: str = "") -> None:
    """Notes, the result, and what was written."""
    say_notes(skin.notes)
    patches = [_plain(patch) for patch in skin]
    plain = {"name": skin.name, "patches": patches}
    summary = f"{sum(map(len, skin))} taxels in {len(skin)} patch{'es' if len(skin) > 1 else ''}"
    if output:
        plain["file"] = output
        finish(as_json, plain, [f"{output}: {summary}"])
    else:
        finish(as_json, plain, lines=[f"{skin.name}: {summary}", *map(_line, patches)])


@layout.command
def generators(*, as_json: Json = False) -> None:
    """List the layouts that need no file, with their arguments and defaults.

    Arguments stand behind a colon, by their names.

      skinfield layout generators
      skinfield layout show cylinder:radius_mm=40 -o cylinder.png
    """
    from skinfield.skin.generators import known

    finish(as_json, list(known()), lines=known())


def _finding_lines(title: str, findings: "list[Finding]") -> Iterator[Shown]:
    from rich.text import Text

    if not findings:
        yield f"{title}: nothing found"
        return
    yield title
    columns = ("severity", "code", "what it means, and what reading the file does about it", "rows")
    shown = table(None, columns, (), show_lines=True)
    shown.columns[0].no_wrap = shown.columns[1].no_wrap = True
    shown.columns[3].max_width = 16
    for finding in findings:
        first = ", ".join(map(str, finding.rows[:MOST_ROWS]))
        total = len(finding.rows)
        rows = first + (f", ... {total} in all" if total > MOST_ROWS else "")
        severity = Text(finding.severity, style=COLOURS[finding.severity])
        shown.add_row(severity, finding.code, Text(finding.message), rows)  # may hold brackets
    yield shown
    yield ", ".join(f"{sum(f.severity == s for f in findings)} {s}" for s in COLOURS)


def _plain(patch: Patch) -> dict[str, Any]:
    """What is to be known of a patch, lengths in mm."""
    from skinfield.skin.geometry import facing_from_positions

    size = patch.positions.max(axis=0) - patch.positions.min(axis=0)
    return {
        "name": patch.name,
        "taxels": len(patch),
        "modules": len(set(patch.module.tolist())),
        "channels": patch.n_channels,
        "pitch_mm": patch.pitch * 1e3 if len(patch) > 1 else None,
        "pad_mm": patch.pad_diameter * 1e3,
        "size_mm": (size * 1e3).tolist(),
        "flat": bool(facing_from_positions(patch.positions).is_flat),
        "link": patch.link or None,
    }


def _line(plain: dict[str, Any]) -> str:
    pitch = plain["pitch_mm"]
    parts = [
        f"{plain['taxels']} taxels",
        f"{plain['modules']} modules",
        f"{plain['channels']} channels",
        "a single place" if pitch is None else f"pitch {pitch:.2f} mm",
        f"pads {plain['pad_mm']:.2f} mm",
        " x ".join(f"{side:.1f}" for side in plain["size_mm"]) + " mm",
        "flat" if plain["flat"] else "curved",
        *([f"on {plain['link']}"] if plain["link"] else []),
    ]
    return f"  {plain['name']}: {', '.join(parts)}"

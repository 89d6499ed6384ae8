"""`skinfield new`: a skin's file from positions of its taxels and a log of it."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from skinfield.cli import options, report
from skinfield.cli.new_log import LogFlags, check_unit, log_settings_for, told_by_presses
from skinfield.cli.profiles import profile_of
from skinfield.cli.questions import Questions, one_of, positive
from skinfield.cli.settings import Elastomer
from skinfield.errors import FileError, InputError
from skinfield.files.layouts.positions import (
    METRES,
    Positions,
    is_picture,
    positions_in_picture,
    read_positions,
)
from skinfield.files.layouts.repair import Content, Draft, Finding, mend
from skinfield.plot import plural
from skinfield.settings import Positive
from skinfield.skin import Patch, Skin
from skinfield.skin.geometry import nearest_distance
from skinfield.skin.log import LogSettings

MATERIALS = {"silicone": 0.5, "rubber": 0.5, "foam": 0.3, "fabric": 0.3}  # Poisson's ratio
FINEST, THICKEST = 1e-3, 50e-3  # m: pitch and cover, beyond which a slip is likelier than a skin
EXAMPLE = "grid:rows=8,cols=8,pitch_mm=4"
HEADER = (
    "# A skin: where its taxels are, what covers it, how its logs are read. From skinfield new.\n"
)


def new(
    *,
    positions: str | None = None,
    log: str | None = None,
    time: str | None = None,
    columns: str | None = None,
    output: Annotated[str, options.OUTPUT] = "my_skin.toml",
    yes: Annotated[bool, Parameter(negative=())] = False,
    as_json: options.Json = False,
    time_unit: str | None = None,
    rate_hz: Annotated[float | None, Positive("readings per second")] = None,
    unit: str | None = None,
    load_cell: str | None = None,
    calibration: str | None = None,
    axes: str | None = None,
    lengths: str | None = None,
    pitch_mm: Annotated[float | None, Positive("distance of neighbours")] = None,
    width_mm: Annotated[float | None, Positive("from the leftmost to the rightmost taxel")] = None,
    pad_mm: Annotated[float | None, Positive("diameter of a pad")] = None,
    patch: options.PatchName = None,
    material: str | None = None,
    elastomer: options.OfElastomer = Elastomer(),
) -> None:
    """Make the file of your own skin, from positions of its taxels and a log of it.

    It asks for what flags do not say, with a guess to confirm; --yes takes the guesses. The file
    holds where the taxels are, what covers them and how logs are read, so that every command takes
    it without further options. Beside it goes a picture, to be looked at: taxels with their
    numbers, rest, noise and faults. The log is best one of some presses on a skin at rest.

      skinfield new
      skinfield new --positions taxels.csv --log log.csv --time t --columns 'ch*' --yes
      skinfield new --positions grid:rows=8,cols=8,pitch_mm=4 --log log.csv --thickness-mm 3 --yes
      skinfield new --positions photo.jpg --pitch-mm 5 --log log.csv --yes
      skinfield reconstruct log.csv --skin my_skin.toml

    Parameters
    ----------
    positions : str, optional
        Where the taxels are: a CSV of x, y (and z) with any column names, a grid such as
        grid:rows=8,cols=8,pitch_mm=4, a picture of equal dots on a plain ground (.png, .jpg), a
        layout file of a maker, or a generator by name.
    log : str, optional
        A log of the skin, or none: CSV with any column names, or a recording of a known format.
    time : str, optional
        Column of the times. Default the one that is named so.
    columns : str, optional
        Columns of the taxels, such as 'ch*', 3-66 or a,b,c. Default the most alike.
    output : str
        The skin's file (.toml); a picture (.png) goes beside it.
    yes : bool
        Ask nothing: take what is found, and write over files that are there.
    time_unit : str, optional
        Of the times: s, ms, us or ns. Default by name and steps.
    rate_hz : float, 1/s, optional
        Readings per second of a log without times.
    unit : str, optional
        Of the values: count, dC/C0, Pa or 1. Default by name and size.
    load_cell : str, optional
        Column of a force that is known, or none.
    calibration : str, optional
        Calibration of this skin (.toml, .npz), if there is one.
    axes : str, optional
        Columns of the positions, such as u,v. Default those named x, y and z.
    lengths : str, optional
        Unit of the positions: mm, cm, m or inch. Default by name and size.
    pitch_mm : float, mm, optional
        Distance of neighbours, of the dots of a picture.
    width_mm : float, mm, optional
        Or the distance from the leftmost to the rightmost one.
    pad_mm : float, mm, optional
        Diameter of a pad. Default 4 mm, or 0.8 pitches on a finer skin.
    material : str, optional
        What covers the taxels: silicone, rubber, foam or fabric.
    """
    ask = Questions(yes)
    picture = _picture_beside(output, positions, ask)
    if calibration is not None:
        options.check_calibration(calibration)
    how = PlacesFlags(axes, lengths, pitch_mm, width_mm, pad_mm)
    skin, where, findings, names = _taxels(ask, positions, how)
    its = options.patch_of(skin, patch)
    file = ask.answer("--log", "A log of it (or none)", log, "none", _there, optional=True)
    settings, known = LogSettings(), None
    if file is not None:
        flags = LogFlags(time=time, time_unit=time_unit, rate_hz=rate_hz, columns=columns,
                         unit=unit, load_cell=load_cell)  # fmt: skip
        settings, its = log_settings_for(file, flags, ask, its, names)
        if unit is None:
            check_unit(file, settings)
        settings, known = told_by_presses(file, settings)
    cover = _cover(ask, elastomer, material, where)
    tables = _tables(cover, calibration, settings)
    from skinfield.cli.new_report import NewSkin, finish_new

    its = replace(its, name=Path(output).stem if its.name in ("patch", "rectangular") else its.name)
    made = NewSkin(
        Skin((its,), name=Path(output).stem, notes=skin.notes), tables, findings, names, file,
        settings, known,
    )  # fmt: skip
    finish_new(made, output, picture, as_json)


def _picture_beside(output: str, positions: str | None, ask: Questions) -> str | None:
    """Name of the picture beside a skin's file; None where none can be drawn.

    What is there already may be written over, or nothing goes on.
    """
    report.check_output("--output", output, True, ".toml")
    picture = report.picture_if_drawable(str(Path(output).with_suffix(".png")))
    if positions is not None and picture is not None and Path(positions) == Path(picture):
        raise InputError(f"{picture} is the positions and would be written over: choose another -o")
    for name in filter(None, (output, picture)):
        if Path(name).exists():
            ask.confirm(f"{name} is there already: write over it?")
    return picture


def _there(text: str) -> str:
    if not (Path(text).exists() or Path(text.rpartition(":")[0]).is_file()):  # FILE.mat:NAME
        raise FileError(f"{text} is not there, expected a log of the skin")
    return text


@dataclass(frozen=True)
class PlacesFlags:
    """What flags say of positions."""

    axes: str | None
    lengths: str | None
    pitch_mm: float | None
    width_mm: float | None
    pad_mm: float | None


def _taxels(
    ask: Questions, positions: str | None, how: PlacesFlags
) -> tuple[Skin, str, tuple[Finding, ...], tuple[str, ...]]:
    """Skin where the taxels are, its source, findings, and names of its taxels if there are any."""

    def read(text: str) -> tuple[Skin, str, tuple[Finding, ...], tuple[str, ...]]:
        return _skin_of(ask, text, how)

    found = ask.answer(
        "--positions", f"Where are the taxels? A CSV, a picture, a maker's file, or {EXAMPLE}",
        positions, None, read,
    )  # fmt: skip
    assert found is not None
    skin, _, findings, _ = found
    for finding in findings:
        report.note(f"{finding.severity}: {finding.message}", "yellow")
    for patch in skin:
        sides = np.ptp(patch.positions, axis=0)
        size = " x ".join(f"{side * 1e3:.4g}" for side in (sides if sides[2] else sides[:2]))
        over = f", {patch.pitch * 1e3:.4g} mm apart, over {size} mm" if len(patch) > 1 else ""
        report.note(f"{plural(len(patch), 'taxel')}{over}")
    return found


def _skin_of(
    ask: Questions, text: str, how: PlacesFlags
) -> tuple[Skin, str, tuple[Finding, ...], tuple[str, ...]]:
    """What `--positions` means."""
    from skinfield.files.layouts.load import fitting_formats, read_layout
    from skinfield.files.layouts.text import read_bytes

    if how.lengths is not None:
        one_of(tuple(METRES))(how.lengths)
    path, pad = Path(text), how.pad_mm
    head = read_bytes(path) if path.is_file() else b""
    if not is_picture(head) and (how.pitch_mm or how.width_mm):
        raise InputError("--pitch-mm and --width-mm are of a picture, expected none beside others")
    if not path.exists():
        name, colon, rest = text.partition(":")
        if name.strip() == "grid":  # the usual word for it
            text = f"rectangular{colon}{rest.replace('cols=', 'columns=')}"
        return _with_pad(options.skin_from_text(text), pad), text, (), ()
    of_maker = path.is_dir() or bool(fitting_formats(head))
    if (of_maker or is_picture(head)) and (how.axes or how.lengths):
        raise InputError("--axes and --lengths are of a CSV, expected none beside others")
    if of_maker and not is_picture(head):
        skin, findings = read_layout(path)
        return _with_pad(skin, pad), text, findings, ()
    table = (_dots if is_picture(head) else _positions)(ask, path, how)
    flat = not np.ptp(table.positions[:, 2])
    up = np.tile([0.0, 0.0, 1.0], (len(table.positions), 1)) if flat else None
    draft = Draft(
        table.positions, np.arange(len(table.positions)),
        up if table.normals is None else table.normals, name=path.stem,
        pad_diameter=None if pad is None else pad * 1e-3,
    )  # fmt: skip
    skin, findings = mend(Content(path, path.stem, (draft,)))
    return skin, text, findings, table.names


def _dots(ask: Questions, path: Path, how: PlacesFlags) -> Positions:
    """Positions in a picture, to a scale that was given or asked for."""
    pitch = how.pitch_mm
    if pitch is None and how.width_mm is None and ask.terminal:
        pitch = ask.answer("--pitch-mm", "Distance of neighbouring taxels, mm", None, None,
                           positive("--pitch-mm", "distance of neighbours"))  # fmt: skip
    pitch, width = (None if mm is None else mm * 1e-3 for mm in (pitch, how.width_mm))
    table = positions_in_picture(path, pitch, width)
    for said in table.notes:
        report.note(said)
    return table


def _positions(ask: Questions, path: Path, how: PlacesFlags) -> Positions:
    """Table of positions, in a unit that was given, asked for, or found."""
    axes = [word.strip() for word in how.axes.split(",")] if how.axes else []
    table = read_positions(path, axes, how.lengths)  # type: ignore[arg-type]
    for said in table.notes:
        report.note(said)
    if table.guessed and ask.terminal and len(table.positions) > 1:
        unit = ask.answer("--lengths", f"Unit of the positions ({', '.join(METRES)})", None,
                          table.unit, one_of(tuple(METRES)))  # fmt: skip
        table = read_positions(path, axes, unit)
    elif table.guessed and len(table.positions) > 1:
        pitch = float(np.median(nearest_distance(np.unique(table.positions, axis=0))))
        if pitch < FINEST:
            report.note(
                f"taxels are {pitch * 1e3:.3g} mm apart, which few skins are: if the positions are "
                "in another unit, say --lengths cm or --lengths inch", "yellow",
            )  # fmt: skip
    return table


def _with_pad(skin: Skin, pad: float | None) -> Skin:
    if pad is None:
        return skin
    patches: tuple[Patch, ...] = tuple(replace(each, pad_diameter=pad * 1e-3) for each in skin)
    return replace(skin, patches=patches)


def _cover(ask: Questions, given: Elastomer, material: str | None, where: str) -> Elastomer:
    """What covers the taxels: a profile, thickness and Poisson's ratio."""
    from skinfield.files.layouts.load import layout_format

    profile = profile_of(given, None, layout_format(where) if Path(where).exists() else "")
    thick, ratio = given.thickness_mm, given.poisson
    if thick is None and ask.terminal:
        usual = f"{profile.thickness_mm:g}"
        thick = ask.answer(
            "--thickness-mm", "Thickness of what covers it, mm", None, usual,
            positive("--thickness-mm", "thickness of the elastomer"),
        )  # fmt: skip
    if ratio is None and (material is not None or ask.terminal):
        usual = "silicone" if profile.poisson > 0.4 else "foam"
        question = f"What covers it ({', '.join(MATERIALS)})"
        word = ask.answer("--material", question, material, usual, one_of(tuple(MATERIALS)))
        ratio = MATERIALS[str(word)]
    elif ratio is not None and material is not None:
        raise InputError("--material and --poisson were both given, expected one of them")
    if thick is not None and thick * 1e-3 > THICKEST:
        raise InputError(
            f"--thickness-mm is {thick:g}, expected {THICKEST * 1e3:g} at most: "
            "through a thicker cover no taxel tells where it is pressed"
        )
    return replace(given, profile=profile.name if given.profile == "auto" else given.profile,
                   thickness_mm=thick, poisson=ratio)  # fmt: skip


def _tables(cover: Elastomer, calibration: str | None, log: LogSettings) -> str:
    """Tables of a skin's file, beside its layout, as TOML."""
    import tomli_w

    def changed_values(section: Any) -> dict[str, Any]:
        usual = type(section)()
        names = [name for name in vars(usual) if getattr(section, name) != getattr(usual, name)]
        values = {name: getattr(section, name) for name in names}
        return {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()}

    skin = changed_values(cover) | ({} if calibration is None else {"calibration": calibration})
    tables = {"skin": skin, "log": changed_values(log)}
    return HEADER + tomli_w.dumps({name: its for name, its in tables.items() if its})

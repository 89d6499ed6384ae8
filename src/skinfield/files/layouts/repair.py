"""Repair of layout files: a layout as its file states it, its faults, what is done about each."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError, Ints
from skinfield.files.layouts.text import listed, many
from skinfield.skin.geometry import Facing, facing_from_positions, nearest_distance
from skinfield.skin.patch import Patch, Skin, millimetres_in

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True)
class Finding:
    """One thing found in a layout file.

    Parameters
    ----------
    code : str
        Short name of the kind, such as ``"inward-normals"``.
    severity : "error", "warning" or "info"
        An error states something false, so that the importer had to replace it or the user has to
        decide; a warning is imprecise or suspicious; an info says what was read or left out.
    message : str
        What was found, what it means, and what the importer does about it.
    rows : tuple of int
        Rows of the file's own table of taxels, from 0; empty when it concerns the whole file.
    """

    code: str
    severity: Severity
    message: str
    rows: tuple[int, ...] = ()


def finding_of_rows(
    code: str, severity: Severity, which: NDArray[np.bool_], name: str, noun: str, text: str
) -> list[Finding]:
    """What is found of some rows (N,) of a patch `name`; nothing if it is none."""
    rows = np.flatnonzero(which).tolist()
    message = f"{name}: {many(len(rows), noun)} (rows {listed(rows)}) {text}"
    return [Finding(code, severity, message, tuple(rows))] if rows else []


@dataclass(frozen=True, eq=False)
class Draft:
    """One patch as a file states it; what the file does not state is None.

    Parameters
    ----------
    positions, normals : (N, 3) arrays
        m and unitless, as written: the file may have meant millimetres, or left normals empty.
    rows : (N,) int array
        Where each taxel stands in the file's own table, from 0.
    stated : bool
        Whether the format states units and directions on purpose: then nothing is changed.
    """

    positions: Floats
    rows: Ints
    normals: Floats | None = None
    module: Ints | None = None
    uid: NDArray[np.uint64] | None = None
    channel: Ints | None = None
    n_channels: int = 0
    pad_diameter: float | None = None
    name: str = "patch"
    link: str = ""
    link_from_patch: Floats | None = None
    stated: bool = False


@dataclass(frozen=True, eq=False)
class Content:
    """All that one file holds.

    Parameters
    ----------
    path : Path
        Of the file.
    name : str
        Of the skin.
    drafts : tuple of Draft
    findings : tuple of Finding
        What reading the file brought up: rows left out, lines that say two things.
    notes : tuple of str
        Sentences that the file itself carries.
    """

    path: Path
    name: str
    drafts: tuple[Draft, ...]
    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = field(default=())


# One direction on all of a skin is a placeholder when the positions tell another one somewhere, by
# more than they can be wrong.
OFF_FLAT, OFF_CURVED = np.cos(np.radians([30.0, 10.0]))
KEPT = "kept as stated"
FROM_POSITIONS = (
    "they are taken from the positions, on the convex side or, where the skin does not bulge, "
    "away from the link's origin (+z if it lies in the skin)"
)


def mend_normals(draft: Draft) -> tuple[Draft, list[Finding]]:
    """Check the normals of a draft against its positions; replace what cannot be."""
    facing = facing_from_positions(draft.positions)
    if draft.normals is None:
        if draft.stated and facing.is_flat:  # our own default: a flat patch faces up
            up = facing.normals[0] @ [1e-6, 1e-3, 1.0]
            return replace(draft, normals=facing.normals * (1.0 if up >= 0 else -1.0)), []
        return replace(draft, normals=facing.normals), [_estimated(draft)]
    length = np.linalg.norm(draft.normals, axis=1)
    missing = ~(length > 1e-3)  # neither a direction nor a rounding of one
    findings = []
    if missing.any():
        text = f"{draft.name}: {many(int(missing.sum()), 'taxel')} without a normal (zeros); it is "
        text += "taken from the positions of the taxels around"
        findings.append(Finding("missing-normals", "warning", text, _rows(draft, missing)))
    off = ~missing & (np.abs(length - 1.0) > 2e-3)
    if off.any():
        text = (
            f"{draft.name}: {many(int(off.sum()), 'normal')} of another length than 1 "
            f"({length[off].min():.3g} to {length[off].max():.3g}); made 1"
        )
        findings.append(Finding("non-unit-normals", "warning", text, _rows(draft, off)))
    scale = np.where(missing, 1.0, length)[:, None]
    unit = np.where(missing[:, None], facing.normals, draft.normals / scale)
    if len(unit) < 3 or missing.all():
        return replace(draft, normals=unit), findings
    if _is_placeholder(unit[~missing], facing):
        found = _placeholder(draft, unit[~missing][0], facing)
        return replace(draft, normals=unit if draft.stated else facing.normals), [*findings, found]
    unit, found_inward = _turn_outward(draft, unit, facing)
    return replace(draft, normals=unit), findings + found_inward


def _rows(draft: Draft, which: NDArray[np.bool_]) -> tuple[int, ...]:
    return tuple(int(row) for row in draft.rows[which])


def _estimated(draft: Draft) -> Finding:
    text = f"{draft.name}: the file holds no normals; {FROM_POSITIONS}"
    return Finding("no-normals", "warning", text)


def _is_placeholder(unit: Floats, facing: Facing) -> bool:
    """Whether one direction stands everywhere although the skin does not face that way.

    On a flat skin one direction is right, whichever of its two sides it names.
    """
    if np.abs(unit - unit[0]).max() > 1e-6:
        return False
    least = OFF_FLAT if facing.is_flat else OFF_CURVED
    return bool((np.abs(facing.normals @ unit[0]) < least).any())


def _placeholder(draft: Draft, normal: Floats, facing: Facing) -> Finding:
    shape = "lies in its plane" if facing.is_flat else "cannot hold for a curved skin"
    shown = " ".join(f"{value:g}" for value in normal + 0.0)
    text = f"{draft.name}: all normals are the placeholder ({shown}), which {shape}; " + (
        KEPT if draft.stated else FROM_POSITIONS
    )
    return Finding("placeholder-normals", "error", text, tuple(draft.rows.tolist()))


def _turn_outward(draft: Draft, unit: Floats, facing: Facing) -> tuple[Floats, list[Finding]]:
    agreement = np.einsum("ni,ni->n", unit, facing.normals)
    told = facing.certain & (np.abs(agreement) > 0.5)  # elsewhere the two do not bear on each other
    if facing.is_flat or not told.any():
        return unit, []
    inward = told & (agreement < 0)
    if not inward.any():
        return unit, []
    most = inward.sum() > 0.5 * told.sum()
    part = "all" if inward.sum() == told.sum() else f"{inward.sum()} of {len(unit)}"
    text = (
        f"{draft.name}: {part} normals point into the robot, as the positions tell: the skin "
        "would be pressed from inside; "
    )
    code = "inward-normals" if most else "mixed-normals"
    if draft.stated:
        return unit, [Finding(code, "warning", text + KEPT, _rows(draft, inward))]
    turned = agreement < 0 if most else inward
    text += f"{'these' if turned.sum() < len(unit) else 'they'} are turned outward"
    return np.where(turned[:, None], -unit, unit), [
        Finding(code, "error", text, _rows(draft, turned))
    ]


LARGEST = 1e6  # of a coordinate, m: a micrometre read as a metre stays below
USUAL_PAD = 4e-3  # m, of the boards of CySkin and iCub

Step = Callable[[Draft], tuple[Draft, list[Finding]]]


def mend(content: Content) -> tuple[Skin, tuple[Finding, ...]]:
    """Repair what a file states; return the skin and everything that was found.

    Raises
    ------
    FileError
        When what is left cannot be a skin.
    """
    findings, patches = list(content.findings), []
    try:
        for draft in content.drafts:
            _check_size(draft)
            for step in (_millimetres, _uids, _repeats, _lonely, _pads, mend_normals):
                draft, found = step(draft)
                findings += found
            patches.append(_patch(draft))
        stated = all(draft.stated for draft in content.drafts)
        notes = content.notes + (() if stated else tuple(f.message for f in findings))
        return Skin(tuple(patches), name=content.name, notes=notes), tuple(findings)
    except FileError:
        raise
    except InputError as error:
        raise FileError(f"{content.path}: {error}") from error


def _check_size(draft: Draft) -> None:
    """Refuse numbers that no skin has, before anything is computed with them."""
    for name, array in (("position", draft.positions), ("normal", draft.normals)):
        if array is None:
            continue
        wrong = np.argwhere(~(np.abs(array) < LARGEST))
        if len(wrong):
            row, column = wrong[0].tolist()
            raise InputError(
                f"{draft.name}: {name} of row {draft.rows[row]} is {array[row, column]}, expected "
                f"numbers below {LARGEST:g}"
            )


def _patch(draft: Draft) -> Patch:
    assert draft.pad_diameter is not None
    return Patch(
        draft.positions,
        draft.pad_diameter,
        normals=draft.normals,  # type: ignore[arg-type]
        module=draft.module,  # type: ignore[arg-type]
        uid=draft.uid,  # type: ignore[arg-type]
        channel=draft.channel,  # type: ignore[arg-type]
        n_channels=draft.n_channels,
        name=draft.name,
        link=draft.link,
        link_from_patch=draft.link_from_patch,  # type: ignore[arg-type]
    )


def _pitch(draft: Draft) -> float:
    """Median distance to the nearest taxel, m; 0 when there is one place only."""
    distance = nearest_distance(draft.positions)
    return float(np.median(distance)) if np.isfinite(distance).all() else 0.0


def _millimetres(draft: Draft) -> tuple[Draft, list[Finding]]:
    """Divide by 1000 what can only be millimetres; a layout that states metres is refused later."""
    why = "" if draft.stated else millimetres_in(draft.positions)
    if not why:
        return draft, []
    found = Finding("millimetres", "error", f"{draft.name}: {why}; positions are divided by 1000")
    return replace(draft, positions=draft.positions / 1000.0), [found]


def _uids(draft: Draft) -> tuple[Draft, list[Finding]]:
    if draft.uid is None:
        return draft, []
    values, which, count = np.unique(draft.uid, return_inverse=True, return_counts=True)
    if (count < 2).all():
        return draft, []
    rows = draft.rows[count[which] > 1]
    text = (
        f"{draft.name}: uid {listed(values[count > 1].tolist())} stands on more than one taxel: "
        "a recording by uid cannot tell them apart; the taxels are kept and read the same column"
    )
    return draft, [Finding("repeated-uids", "error", text, tuple(rows.tolist()))]


def _repeats(draft: Draft) -> tuple[Draft, list[Finding]]:
    _, which, count = np.unique(
        draft.positions.round(9), axis=0, return_inverse=True, return_counts=True
    )
    if (count < 2).all():
        return draft, []
    rows = draft.rows[count[which.reshape(-1)] > 1]
    text = (
        f"{draft.name}: {len(rows)} taxels stand on only {many(int((count > 1).sum()), 'place')}: "
        "pads that were cut off, or a placeholder; they are kept as channels, and where a "
        "triangulation needs distinct places they count as one"
    )
    return draft, [Finding("repeated-positions", "warning", text, tuple(rows.tolist()))]


def _lonely(draft: Draft) -> tuple[Draft, list[Finding]]:
    distance = nearest_distance(draft.positions)
    if len(distance) < 3 or not np.isfinite(distance).all():
        return draft, []
    far = distance > 3.0 * np.median(distance)
    if not far.any():
        return draft, []
    text = (
        f"{draft.name}: {many(int(far.sum()), 'taxel')} without a neighbour within three pitches "
        f"(up to {distance.max() * 1e3:.1f} mm): a wrong position, or a lone taxel whose "
        "surroundings cannot be seen; kept"
    )
    return draft, [Finding("isolated-taxels", "warning", text, tuple(draft.rows[far].tolist()))]


def _pads(draft: Draft) -> tuple[Draft, list[Finding]]:
    pitch, stated = _pitch(draft), draft.pad_diameter
    usual = USUAL_PAD if pitch == 0.0 or pitch > USUAL_PAD else round(0.8 * pitch, 9)
    if stated is None:
        text = f"{draft.name}: the file gives no size of the pads: {usual * 1e3:.3g} mm are taken"
        return replace(draft, pad_diameter=usual), [Finding("pad-size", "info", text)]
    if pitch == 0.0 or stated <= 1.001 * pitch:
        return draft, []
    text = (
        f"{draft.name}: pads of {stated * 1e3:g} mm would overlap at a pitch of "
        f"{pitch * 1e3:.2f} mm, so this is no pad's diameter (a range of the sensor, maybe); "
    )
    if draft.stated:
        return draft, [Finding("pad-overlap", "warning", text + "kept as stated")]
    found = Finding("pad-overlap", "warning", text + f"{usual * 1e3:.3g} mm are taken")
    return replace(draft, pad_diameter=usual), [found]

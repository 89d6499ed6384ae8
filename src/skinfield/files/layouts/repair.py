"""Repair of layout files: a layout as its file states it, its faults, what is done about each."""

from dataclasses import dataclass
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
    notes: tuple[str, ...] = ()


# One direction on all of a skin is a placeholder when the positions tell another one somewhere, by
# more than they can be wrong.
OFF_FLAT, OFF_CURVED = np.cos(np.radians([30.0, 10.0]))
LARGEST = 1e6  # of a coordinate, m: a micrometre read as a metre stays below
USUAL_PAD = 4e-3  # m, of the boards of CySkin and iCub
KEPT = "kept as stated"
FROM_POSITIONS = (
    "they are taken from the positions, on the convex side or, where the skin does not bulge, "
    "away from the link's origin (+z if it lies in the skin)"
)


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
            repair = _Repair(draft)
            patches.append(repair.patch())
            findings += repair.findings
        stated = all(draft.stated for draft in content.drafts)
        notes = content.notes + (() if stated else tuple(f.message for f in findings))
        return Skin(tuple(patches), name=content.name, notes=notes), tuple(findings)
    except FileError:
        raise
    except InputError as error:
        raise FileError(f"{content.path}: {error}") from error


def _check_size(draft: Draft) -> None:
    """Refuse arrays and numbers that no skin has, before anything is computed with them."""
    count = len(draft.rows)
    for name in ("positions", "normals", "module", "uid", "channel"):
        array = getattr(draft, name)
        if array is None:
            continue
        shape = (count, 3) if name in ("positions", "normals") else (count,)
        if array.shape != shape or not count:
            raise InputError(
                f"{draft.name}: {name} has shape {array.shape}, expected {shape}, one row per taxel"
            )
        wrong = np.argwhere(~(np.abs(array) < LARGEST)) if array.ndim == 2 else ()
        for row, column in wrong[:1]:
            raise InputError(
                f"{draft.name}: {name} of row {draft.rows[row]} is {array[row, column]}, expected "
                f"numbers below {LARGEST:g}"
            )


class _Repair:
    """Faults of a draft, and what is done about each."""

    def __init__(self, draft: Draft) -> None:
        self.draft = draft
        self.findings: list[Finding] = []

    def patch(self) -> Patch:
        """The patch that the draft stands for."""
        draft = self.draft
        positions = self._metres()
        distance = nearest_distance(positions)
        self._taxels(positions, distance)
        return Patch(
            positions,
            self._pad(float(np.median(distance)) if np.isfinite(distance).all() else 0.0),
            normals=self._normals(positions),
            module=draft.module,  # type: ignore[arg-type]
            uid=draft.uid,  # type: ignore[arg-type]
            channel=draft.channel,  # type: ignore[arg-type]
            n_channels=draft.n_channels,
            name=draft.name,
            link=draft.link,
            link_from_patch=draft.link_from_patch,  # type: ignore[arg-type]
        )

    def _note(
        self, code: str, severity: Severity, text: str, which: NDArray[np.bool_] | None = None
    ) -> None:
        """Note a finding, of some of the taxels; nothing if it is of none."""
        rows = () if which is None else tuple(self.draft.rows[which].tolist())
        if rows or which is None:
            self.findings.append(Finding(code, severity, f"{self.draft.name}: {text}", rows))

    def _metres(self) -> Floats:
        """Positions; what can only be millimetres is divided, unless metres were stated."""
        positions = self.draft.positions
        why = "" if self.draft.stated else millimetres_in(positions)
        if not why:
            return positions
        self._note("millimetres", "error", f"{why}; positions are divided by 1000")
        return positions / 1000.0

    def _taxels(self, positions: Floats, distance: Floats) -> None:
        """Note taxels that share a uid or a place, and those far from all others."""
        uid = np.arange(len(positions)) if self.draft.uid is None else self.draft.uid
        values, which, count = np.unique(uid, return_inverse=True, return_counts=True)
        text = (
            f"uid {listed(values[count > 1].tolist())} stands on more than one taxel: a recording "
            "by uid cannot tell them apart; the taxels are kept and read the same column"
        )
        self._note("repeated-uids", "error", text, count[which] > 1)
        _, which, count = np.unique(
            positions.round(9), axis=0, return_inverse=True, return_counts=True
        )
        repeated = count[which.reshape(-1)] > 1
        text = (
            f"{repeated.sum()} taxels stand on only {many(int((count > 1).sum()), 'place')}: pads "
            "that were cut off, or a placeholder; they are kept as channels, and where a "
            "triangulation needs distinct places they count as one"
        )
        self._note("repeated-positions", "warning", text, repeated)
        if len(distance) < 3 or not np.isfinite(distance).all():
            return
        far = distance > 3.0 * np.median(distance)
        text = (
            f"{many(int(far.sum()), 'taxel')} without a neighbour within three pitches (up to "
            f"{distance.max() * 1e3:.1f} mm): a wrong position, or a lone taxel whose surroundings "
            "cannot be seen; kept"
        )
        self._note("isolated-taxels", "warning", text, far)

    def _pad(self, pitch: float) -> float:
        """Diameter of the pads, m; `pitch` 0 where there is one place only."""
        stated = self.draft.pad_diameter
        usual = USUAL_PAD if pitch == 0.0 or pitch > USUAL_PAD else round(0.8 * pitch, 9)
        if stated is None:
            text = f"the file gives no size of the pads: {usual * 1e3:.3g} mm are taken"
            self._note("pad-size", "info", text)
            return usual
        if pitch == 0.0 or stated <= 1.001 * pitch:
            return stated
        what = KEPT if self.draft.stated else f"{usual * 1e3:.3g} mm are taken"
        text = (
            f"pads of {stated * 1e3:g} mm would overlap at a pitch of {pitch * 1e3:.2f} mm, so "
            f"this is no pad's diameter (a range of the sensor, maybe); {what}"
        )
        self._note("pad-overlap", "warning", text)
        return stated if self.draft.stated else usual

    def _normals(self, positions: Floats) -> Floats:
        """Normals, checked against the positions, in place of what cannot be."""
        facing, stated = facing_from_positions(positions), self.draft.stated
        if (normals := self.draft.normals) is None:
            if stated and facing.is_flat:  # our own default: a flat patch faces up
                up = facing.normals[0] @ [1e-6, 1e-3, 1.0]
                return facing.normals * (1.0 if up >= 0 else -1.0)
            self._note("no-normals", "warning", f"the file holds no normals; {FROM_POSITIONS}")
            return facing.normals
        length = np.linalg.norm(normals, axis=1)
        missing = ~(length > 1e-3)  # neither a direction nor a rounding of one
        text = (
            f"{many(int(missing.sum()), 'taxel')} without a normal (zeros); it is taken from the "
            "positions of the taxels around"
        )
        self._note("missing-normals", "warning", text, missing)
        off = ~missing & (np.abs(length - 1.0) > 2e-3)
        if off.any():
            text = (
                f"{many(int(off.sum()), 'normal')} of another length than 1 "
                f"({length[off].min():.3g} to {length[off].max():.3g}); made 1"
            )
            self._note("non-unit-normals", "warning", text, off)
        scale = np.where(missing, 1.0, length)[:, None]
        unit = np.where(missing[:, None], facing.normals, normals / scale)
        if len(unit) < 3 or missing.all():
            return unit
        if _is_placeholder(unit[~missing], facing):
            shape = "lies in its plane" if facing.is_flat else "cannot hold for a curved skin"
            shown = " ".join(f"{value:g}" for value in unit[~missing][0] + 0.0)
            text = f"all normals are the placeholder ({shown}), which {shape}; "
            text += KEPT if stated else FROM_POSITIONS
            self._note("placeholder-normals", "error", text, np.ones(len(unit), bool))
            return unit if stated else facing.normals
        return self._outward(unit, facing)

    def _outward(self, unit: Floats, facing: Facing) -> Floats:
        """Turn normals that point into the robot, unless they were stated."""
        agreement = np.einsum("ni,ni->n", unit, facing.normals)
        sure = facing.certain & (np.abs(agreement) > 0.5)  # else they say nothing of it
        inward = sure & (agreement < 0)
        if facing.is_flat or not inward.any():
            return unit
        most = inward.sum() > 0.5 * sure.sum()
        part = "all" if inward.sum() == sure.sum() else f"{inward.sum()} of {len(unit)}"
        turned = agreement < 0 if most else inward
        text = (
            f"{part} normals point into the robot, as the positions tell: the skin would be "
            "pressed from inside; "
        )
        code = "inward-normals" if most else "mixed-normals"
        if self.draft.stated:
            self._note(code, "warning", text + KEPT, inward)
            return unit
        text += f"{'these' if turned.sum() < len(unit) else 'they'} are turned outward"
        self._note(code, "error", text, turned)
        return np.where(turned[:, None], -unit, unit)


def _is_placeholder(unit: Floats, facing: Facing) -> bool:
    """Whether one direction stands everywhere although the skin does not face that way.

    On a flat skin one direction is right, whichever of its two sides it names.
    """
    if np.abs(unit - unit[0]).max() > 1e-6:
        return False
    least = OFF_FLAT if facing.is_flat else OFF_CURVED
    return bool((np.abs(facing.normals @ unit[0]) < least).any())

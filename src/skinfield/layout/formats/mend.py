"""The faults of layout files: found, said, and repaired in one place.

Reading a file and linting it run the same steps, so a lint cannot promise what reading does not do.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.layout.finding import Finding
from skinfield.layout.formats.directions import mend_normals
from skinfield.layout.formats.draft import Content, Draft
from skinfield.layout.formats.text import listed, many
from skinfield.layout.normals import nearest_distance
from skinfield.layout.patch import Patch
from skinfield.layout.skin import Skin

COARSEST = 0.5  # m between taxels: no skin has that, so the file is in millimetres
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
    pitch = _pitch(draft)
    if pitch <= COARSEST:
        return draft, []
    extent = np.ptp(draft.positions, axis=0).max()
    text = (
        f"{draft.name}: taxels are {pitch:.3g} m apart over {extent:.3g} m, which no skin is: "
        "these are millimetres given as metres; "
    )
    if draft.stated:
        return draft, [Finding("millimetres", "error", text + "kept as stated")]
    found = Finding("millimetres", "error", text + "positions are divided by 1000")
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

"""The faults of normals: missing, not unit, placeholders, inward."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.layout.finding import Finding
from skinfield.layout.formats.draft import Draft
from skinfield.layout.formats.text import many
from skinfield.layout.normals import Facing, facing_from_positions

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

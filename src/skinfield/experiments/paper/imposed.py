"""Figures 3 to 5: a deformation of 0.2 mm on three taxels, reconstructed without noise."""

from skinfield.experiments.paper.imposed_found import GRIDS, Found, all_found
from skinfield.experiments.paper.imposed_pictures import picture_of_fields, picture_of_peaks
from skinfield.experiments.paper.imposed_truth import (
    ADJACENT,
    DEPTH,
    HALF_SPACE,
    LAYER,
    OWN_GRID,
    SEPARATE,
)
from skinfield.experiments.paper.methods import FIELD, PAPER, PAPER_EXACT, Method
from skinfield.experiments.section import Section, Table, Verdict
from skinfield.experiments.settings import Settings
from skinfield.experiments.words import listed, spread_in_words

RIGHT = 0.15  # of 0.2 mm: a peak within it counts as right
CLAIM = (
    "A deformation of 0.2 mm on three adjacent taxels is reconstructed with its peak around 0.2 mm "
    "on 20 × 20, 30 × 30 and 40 × 40 nodes; the force is smoothed, the more the denser the grid. "
    "On three separate taxels the three peaks are centred around 0.2 mm and stay distinct."
)


def imposed(settings: Settings) -> Section:
    """Peaks, widths and number of contacts for each way of making the readings."""
    found = all_found(settings)
    pictures = [picture_of_fields(found, case) for case in (ADJACENT, SEPARATE)]
    return Section(
        name="imposed",
        title="Figures 3 to 5: a deformation imposed on three taxels",
        claim=CLAIM,
        sentences=tuple(_sentences(found)),
        pictures=(*(p for pair in pictures for p in pair), picture_of_peaks(found)),
        tables=(_short_table(found), _table(found)),
        verdicts=tuple(_verdicts(found)),
    )


def _of(found: list[Found], world: str, case: str, method: Method) -> list[Found]:
    return [
        each
        for each in found
        if (each.truth.world, each.truth.case) == (world, case) and each.method is method
    ]


def _claimed(each: Found) -> list[float]:
    """The peaks in m that the paper speaks of: of the whole, or of each separate disc."""
    peaks = [float(peak) for peak in each.peaks]
    return [max(peaks)] if each.truth.case == ADJACENT else peaks


def _peaks(found: list[Found]) -> str:
    return spread_in_words([peak for each in found for peak in _claimed(each)], "mm", 1e3)


def _sentences(found: list[Found]) -> list[str]:
    real = {case: _of(found, LAYER, case, PAPER) for case in (ADJACENT, SEPARATE)}
    ours = {case: _of(found, LAYER, case, FIELD) for case in (ADJACENT, SEPARATE)}
    crime = _of(found, HALF_SPACE, SEPARATE, PAPER)
    own = _of(found, OWN_GRID, SEPARATE, PAPER)
    exact = _of(found, LAYER, SEPARATE, PAPER_EXACT)
    wide = real[ADJACENT]
    grids, sides = listed([f"{n} × {n}" for n in GRIDS]), listed([str(n) for n in GRIDS])
    return [
        f"Three flat discs as wide as a pad are pushed {DEPTH * 1e3:g} mm deep; nothing is added "
        "to the readings. They are made in three ways: on the bonded layer, by the contact solver, "
        "with pads that read their mean stress; on the paper's half-space, with stress at the "
        "pads' centres (the same mechanics in both directions, so an inverse crime, though on a "
        "grid of its own); and from forces on the very nodes that are then reconstructed.",
        f"Peak deformation found by the paper's method on three separate taxels: "
        f"{_peaks(real[SEPARATE])} on the layer, {_peaks(crime)} on the half-space, {_peaks(own)} "
        f"from its own nodes; ours {_peaks(ours[SEPARATE])} on the layer. From its own nodes the "
        "mechanics cancel, so what is wrong there is lost between the taxels, where readings are "
        "interpolated. With the exact Ψ in place of 0.25 the paper's method finds "
        f"{_peaks(exact)}.",
        f"Full width at half maximum around the three adjacent taxels, on {grids} nodes (paper, "
        f"layer): pressure {_widths(wide, 0)} mm where the truth on the same nodes has "
        f"{_true_widths(wide, 0)} mm, deformation {_widths(wide, 1)} mm for "
        f"{_true_widths(wide, 1)} mm.",
        "Of the force on three separate taxels the paper's method finds "
        f"{_forces(real[SEPARATE])}, ours {_forces(ours[SEPARATE])}, on {sides} nodes a side. The "
        f"deformation is off by {_errors(real[SEPARATE])} (paper) and {_errors(ours[SEPARATE])} "
        "(ours), relative L2 among the taxels.",
    ]


def _widths(found: list[Found], which: int) -> str:
    return listed([f"{1e3 * each.widths[which]:.1f}" for each in found])


def _true_widths(found: list[Found], which: int) -> str:
    return listed([f"{1e3 * each.true_widths[which]:.1f}" for each in found])


def _forces(found: list[Found]) -> str:
    return listed([f"{100 * each.force:.0f} %" for each in found])


def _errors(found: list[Found]) -> str:
    return listed([f"{100 * each.deformation_error:.0f} %" for each in found])


def _table(found: list[Found]) -> Table:
    columns = (
        "readings made on",
        "imposed on",
        "method",
        "nodes on a side",
        "lowest peak (mm)",
        "highest peak (mm)",
        "width of pressure (mm)",
        "true (mm)",
        "width of deformation (mm)",
        "true width (mm)",
        "force found (%)",
        "deformation, relative L2 (%)",
        "contacts found",
        "discs with a contact",
    )
    rows = tuple(
        (
            each.truth.world,
            each.truth.case,
            each.method.name,
            each.nodes,
            1e3 * float(each.peaks.min()),
            1e3 * float(each.peaks.max()),
            1e3 * float(each.widths[0]),
            1e3 * float(each.true_widths[0]),
            1e3 * float(each.widths[1]),
            1e3 * float(each.true_widths[1]),
            100 * each.force,
            100 * each.deformation_error,
            each.contacts,
            each.matched,
        )
        for each in found
    )
    caption = (
        "Every method, grid and way of making the readings. Widths are full widths at half "
        "maximum; the true ones are of the truth brought onto the same nodes."
    )
    return Table("all", caption, columns, rows, shown=False)


def _short_table(found: list[Found]) -> Table:
    columns = (
        "imposed on",
        "method",
        "nodes on a side",
        "peaks (mm)",
        "width of pressure / true (mm)",
        "width of deformation / true (mm)",
        "force found (%)",
        "deformation, relative L2 (%)",
        "contacts",
    )
    rows = tuple(
        (
            each.truth.case,
            each.method.name,
            each.nodes,
            f"{1e3 * each.peaks.min():.2f} to {1e3 * each.peaks.max():.2f}",
            f"{1e3 * each.widths[0]:.1f} / {1e3 * each.true_widths[0]:.1f}",
            f"{1e3 * each.widths[1]:.1f} / {1e3 * each.true_widths[1]:.1f}",
            100 * each.force,
            100 * each.deformation_error,
            each.contacts,
        )
        for case in (ADJACENT, SEPARATE)
        for method in (PAPER, FIELD)
        for each in _of(found, LAYER, case, method)
    )
    caption = (
        "On the layer. Widths are full widths at half maximum; the true ones are of the truth "
        "brought onto the same nodes. all.csv has every method and way of making the readings."
    )
    return Table("layer", caption, columns, rows)


def _near(each: Found) -> bool:
    """Whether the peaks are right."""
    return all(abs(peak / DEPTH - 1) < RIGHT for peak in _claimed(each))


def _verdicts(found: list[Found]) -> list[Verdict]:
    by_world = {
        case: {world: _of(found, world, case, PAPER) for world in (LAYER, HALF_SPACE, OWN_GRID)}
        for case in (ADJACENT, SEPARATE)
    }
    claims = {
        ADJACENT: ("4", "the peak of the deformation is around 0.2 mm"),
        SEPARATE: ("5", "the three peaks are around 0.2 mm"),
    }
    peaks = [
        Verdict(*claims[case], _measured(worlds), _holds(worlds))
        for case, worlds in by_world.items()
    ]
    layer = by_world[ADJACENT][LAYER]
    blur = [float(each.widths[0] / each.true_widths[0]) for each in layer]
    grows = min(blur) > 1 and blur[-1] > blur[0]
    separate = by_world[SEPARATE][LAYER]
    distinct = [each.separated for each in separate]
    return [
        peaks[0],
        Verdict(
            "4",
            "the force is smoothed, the more the denser the grid",
            f"width {_widths(layer, 0)} mm where the same nodes can show "
            f"{_true_widths(layer, 0)} mm: {listed([f'{b:.1f}' for b in blur])} times",
            "holds" if grows else "does not hold",
        ),
        peaks[1],
        Verdict(
            "5",
            "three contacts stay distinct",
            f"{listed([str(each.contacts) for each in separate])} contacts found on "
            f"{listed([str(n) for n in GRIDS])} nodes a side",
            "holds"
            if all(distinct)
            else "holds only in part"
            if any(distinct)
            else "does not hold",
        ),
    ]


def _measured(worlds: dict[str, list[Found]]) -> str:
    return (
        f"{_peaks(worlds[LAYER])} on the layer, {_peaks(worlds[HALF_SPACE])} on the half-space, "
        f"{_peaks(worlds[OWN_GRID])} from its own nodes"
    )


def _holds(worlds: dict[str, list[Found]]) -> str:
    """Verdict on the layer, within the tolerance."""
    right = [each.nodes for each in worlds[LAYER] if _near(each)]
    if len(right) == len(GRIDS):
        return "holds"
    if right:
        return f"holds only on {listed([f'{n} × {n}' for n in right])} (to {100 * RIGHT:.0f} %)"
    return f"does not hold (to {100 * RIGHT:.0f} %)"

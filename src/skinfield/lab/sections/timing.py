"""Time per reading, Figure 9: against the grid, the paper's way and prepared once."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.lab.bench.machine import laps
from skinfield.lab.paper import PAPER, paper_patch, reconstruct_as_paper, stress_matrix
from skinfield.lab.plots import Curve, Panel, Scale, draw_panels
from skinfield.lab.report import Picture, Section, Settings, Table, Verdict, spread_in_words
from skinfield.plot.style import number, plus_minus

PREPARED_LAPS = 100  # per lap of the paper's algorithm
NEGLIGIBLE = 0.1  # of the mean: a standard deviation below it is
CLAIM = (
    "The time grows exponentially with the resolution; its standard deviation is almost "
    "negligible; most of it is the inversion, and the rest takes less than 0.4 ms on 20 × 20 and "
    "about 1.4 ms on 40 × 40 nodes."
)


@dataclass(frozen=True, eq=False)
class Times:
    """Seconds of each lap on one grid.

    Attributes
    ----------
    nodes : int
        On a side.
    paper : (laps,) array
        Triangulation, interpolation, matrix, inversion, displacements: all of it.
    inversion : (laps,) array
        The inversion alone.
    prepared : (laps,) array
        The same outputs from the operator that was prepared once.
    """

    nodes: int
    paper: Floats
    inversion: Floats
    prepared: Floats

    @property
    def gain(self) -> float:
        """Paper's time over ours, by medians."""
        return float(np.median(self.paper) / np.median(self.prepared))


def timing(settings: Settings) -> Section:
    """Mean and deviation of the time per reading; nothing else may run beside it."""
    times = [times_on(nodes, settings) for nodes in settings.size.grids]
    power, about_power, about_exponential = exponents(times)
    shares = [float(each.inversion.min() / each.paper.min()) for each in times]
    rest = [max(float(each.paper.min() - each.inversion.min()), 0.0) for each in times]
    deviation = max(float(each.paper.std() / each.paper.mean()) for each in times)
    first, last = times[0], times[-1]
    return Section(
        name="timing",
        title="Figure 9: time per reading",
        claim=CLAIM,
        sentences=(
            f"One process, one core, {settings.size.laps} laps per grid after one that does not "
            "count. The paper's algorithm triangulates, interpolates, inverts and computes "
            "displacements for each reading; ours does all of it once, and a reading costs one "
            "product with a matrix.",
            f"On {last.nodes} × {last.nodes} nodes the paper's way takes {_ms(last.paper)} (mean "
            f"and standard deviation), ours {_ms(last.prepared)}: by medians "
            f"{number(last.gain, 2)} times less ({number(first.gain, 2)} times on {first.nodes} × "
            f"{first.nodes}).",
            f"The fastest laps grow as the number of nodes to the power {power:.1f}: a power law "
            f"is off by {100 * about_power:.0f} % of the time, an exponential in the number of "
            f"nodes by {100 * about_exponential:.0f} %.",
            f"The inversion alone is {', '.join(f'{100 * share:.0f} %' for share in shares)} of "
            "the fastest lap, from the coarsest grid to the finest; the rest takes "
            f"{', '.join(number(1e3 * each, 2) for each in rest)} ms. The times are of this "
            "machine and of NumPy; the paper's are of its own in C++.",
        ),
        pictures=(_picture(times),),
        tables=(_table(times),),
        verdicts=(
            Verdict(
                "9",
                "time grows exponentially with the resolution",
                f"grows as the number of nodes to the power {power:.1f}",
                "does not hold: a power law fits better"
                if about_power < about_exponential
                else "holds on these grids",
            ),
            Verdict(
                "9",
                "the deviation of the time is almost negligible",
                f"at most {100 * deviation:.0f} % of the mean",
                "holds" if deviation < NEGLIGIBLE else "does not hold on this machine",
            ),
            Verdict(
                "9",
                "most of the time is the inversion",
                f"{spread_in_words(shares, '%', 100.0)}, most on the finest grid",
                "holds"
                if min(shares) > 0.5
                else "holds only on fine grids"
                if shares[-1] > 0.5
                else "does not hold in NumPy",
            ),
        ),
    )


def times_on(nodes: int, settings: Settings) -> Times:
    """Laps of both ways on `nodes` x `nodes`."""
    patch, layer, count = paper_patch(), settings.layer, settings.size.laps
    readings = np.random.default_rng(settings.seed).normal(scale=1e3, size=len(patch))
    reconstruct = PAPER.prepared(patch, layer, nodes, settings.stress_noise)
    grid = reconstruct.grid
    plane, area = grid.plane, grid.cell_area
    matrix = stress_matrix(plane[:, None] - plane[None], layer.thickness)
    out = np.empty(4 * len(grid))
    return Times(
        nodes,
        laps(lambda: reconstruct_as_paper(readings, patch.plane, plane, layer, area), count, 1),
        laps(lambda: np.linalg.inv(matrix), count, 1),
        laps(lambda: reconstruct.apply(readings, out), PREPARED_LAPS * count, 1),
    )


def exponents(times: list[Times]) -> tuple[float, float, float]:
    """Power of K, and the scatter (of ln t) about a power law and about an exponential in K."""
    nodes = np.array([each.nodes**2 for each in times], dtype=float)
    values = np.log([each.paper.min() for each in times])
    power, rest = np.polyfit(np.log(nodes), values, 1, full=True)[:2]
    rest_exponential = np.polyfit(nodes, values, 1, full=True)[1]
    scatter = [float(np.sqrt(r.sum() / len(times))) for r in (rest, rest_exponential)]
    return float(power[0]), scatter[0], scatter[1]


def _ms(values: Floats) -> str:
    return f"{plus_minus(1e3 * float(values.mean()), 1e3 * float(values.std()))} ms"


def _picture(times: list[Times]) -> Picture:
    x = np.array([float(each.nodes) for each in times])
    curves = []
    for name, several in (
        ("paper's algorithm, each reading", [each.paper for each in times]),
        ("its inversion alone", [each.inversion for each in times]),
        ("ours, prepared once", [each.prepared for each in times]),
    ):
        low, middle, high = 1e3 * np.percentile(several, (5, 50, 95), axis=1)
        curves.append(Curve(name, x, middle, low, high))
    scale = Scale(
        x="nodes on a side", y="time per reading (ms)", log_y=True, x_ticks=tuple(x.tolist()),
        marks=True,
    )  # fmt: skip
    note = "median, bands hold nine of ten laps"
    panel = Panel("Time per reading", note, tuple(curves), scale)
    caption = (
        "Time per reading against the grid, on a logarithmic axis; the table has means and "
        "standard deviations, as the paper."
    )
    return Picture.of("times", caption, draw_panels([[panel]]))


def _table(times: list[Times]) -> Table:
    rows = []
    for each in times:
        cells: dict[str, str | float] = {"nodes on a side": each.nodes}
        for name, laps_of in (
            ("paper", each.paper), ("inversion", each.inversion), ("ours", each.prepared)
        ):  # fmt: skip
            cells |= {
                f"{name}, {what} (ms)": 1e3 * float(value(laps_of))
                for what, value in (("mean", np.mean), ("std", np.std), ("median", np.median))
            }
        rows.append(cells | {"median over median": each.gain})
    caption = "Times per reading, double precision, one core; last the paper's over ours."
    return Table.of("times", caption, rows)

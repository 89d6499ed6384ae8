"""Time per reading, Figure 9: against the grid, the paper's way and prepared once."""

import numpy as np

from skinfield.errors import Floats
from skinfield.lab.bench.run import INVERSION, PAPER, PREPARED, grid_rows, methods_of_paper
from skinfield.lab.bench.scene import BenchSize
from skinfield.lab.paper import paper_patch
from skinfield.lab.plots import Curve, Panel, Scale, draw_panels
from skinfield.lab.report import Chapter, Claim, Effort, Picture, Table, spread_in_words, verdict_of
from skinfield.lab.score import Row
from skinfield.plot import number

PREPARED_LAPS = 100  # per lap of the paper's algorithm
NAMES = {
    PAPER: "paper's algorithm, each reading",
    INVERSION: "its inversion alone",
    PREPARED: "ours, prepared once",
}
NEGLIGIBLE = 0.1  # of the mean: a standard deviation below it is
CLAIM = (
    "The time grows exponentially with the resolution; its standard deviation is almost "
    "negligible; most of it is the inversion, and the rest takes less than 0.4 ms on 20 × 20 and "
    "about 1.4 ms on 40 × 40 nodes."
)


def timing(settings: Effort) -> Chapter:
    """Mean and deviation of the time per reading; nothing else may run beside it."""
    grids, count = settings.grids, settings.laps
    size = BenchSize(
        name=settings.name, grids=grids, readings=1, rounds=1, paper_laps=count,
        laps=PREPARED_LAPS * count, steps=1,
    )  # fmt: skip
    rng = np.random.default_rng(settings.seed)
    readings = rng.normal(scale=1e3, size=(1, len(paper_patch())))
    rows = grid_rows(size, lambda nodes: methods_of_paper(size, readings, nodes))
    times = {name: [r["seconds_us"] for r in rows if r["name"] == name] for name in NAMES}
    paper, inversion, ours = times.values()
    fastest = np.array([[one["min"] for one in each] for each in (paper, inversion)])
    power, about_power, about_exponential = exponents(grids, fastest[0])
    rest = np.maximum(fastest[0] - fastest[1], 0.0) * 1e-3
    deviation = max(one["std"] / one["mean"] for one in paper)
    gains = [one["p50"] / other["p50"] for one, other in zip(paper, ours, strict=True)]
    return Chapter(
        title="Figure 9: time per reading",
        claim=CLAIM,
        sentences=(
            f"One process, one core, {count} laps per grid after one that does not "
            "count. The paper's algorithm triangulates, interpolates, inverts and computes "
            "displacements for each reading; ours does all of it once, and a reading costs one "
            "product with a matrix. The times are of this machine and of NumPy; the paper's are of "
            "its own in C++.",
            f"Of the fastest laps, a power law of the number of nodes is off by "
            f"{100 * about_power:.0f} % of the time, an exponential by "
            f"{100 * about_exponential:.0f} %; all but the inversion takes "
            f"{', '.join(number(each, 2) for each in rest)} ms, from the coarsest grid to the "
            "finest.",
        ),
        pictures=(_picture(grids, times),),
        tables=(_table(grids, times, gains),),
        verdicts=(
            Claim(
                "9",
                "time grows exponentially with the resolution",
                f"grows as the number of nodes to the power {power:.1f}",
                "does not hold: a power law fits better"
                if about_power < about_exponential
                else "holds on these grids",
            ),
            Claim(
                "9",
                "the deviation of the time is almost negligible",
                f"at most {100 * deviation:.0f} % of the mean",
                verdict_of(deviation < NEGLIGIBLE, no="does not hold on this machine"),
            ),
            _of_inversion(fastest[1] / fastest[0]),
        ),
    )


def _of_inversion(shares: Floats) -> Claim:
    """Whether most of the time is the inversion, by its share on each grid."""
    words = f"{spread_in_words(shares.tolist(), '%', 100.0)}, most on the finest grid"
    if min(shares) > 0.5:
        verdict = "holds"
    else:
        verdict = "holds only on fine grids" if shares[-1] > 0.5 else "does not hold in NumPy"
    return Claim("9", "most of the time is the inversion", words, verdict)


def exponents(grids: tuple[int, ...], times: Floats) -> tuple[float, float, float]:
    """Power of the nodes, and the scatter (of ln t) about it and about an exponential in them.

    Parameters
    ----------
    grids : tuple of int
        Nodes on a side.
    times : (grids,) array
    """
    nodes, values = np.array(grids, dtype=float) ** 2, np.log(times)
    power, rest = np.polyfit(np.log(nodes), values, 1, full=True)[:2]
    rest_exponential = np.polyfit(nodes, values, 1, full=True)[1]
    scatter = [float(np.sqrt(r.sum() / len(times))) for r in (rest, rest_exponential)]
    return float(power[0]), scatter[0], scatter[1]


def _picture(grids: tuple[int, ...], times: dict[str, list[Row]]) -> Picture:
    x = np.array(grids, dtype=float)
    curves = []
    for name, words in NAMES.items():
        low, middle, high = (
            1e-3 * np.array([each[key] for each in times[name]]) for key in ("p10", "p50", "p90")
        )
        curves.append(Curve(words, x, middle, low, high))
    scale = Scale(
        x="nodes on a side", y="time per reading (ms)", log_y=True, x_ticks=tuple(x.tolist()),
        marks=True,
    )  # fmt: skip
    note = "median, bands hold eight of ten laps"
    panel = Panel("Time per reading", note, tuple(curves), scale)
    caption = "Time per reading against the grid; the table has means and deviations."
    return Picture.of("times", caption, draw_panels([[panel]]))


def _table(grids: tuple[int, ...], times: dict[str, list[Row]], gains: list[float]) -> Table:
    rows = [
        {"nodes on a side": nodes}
        | {
            f"{short}, {what} (ms)": 1e-3 * times[name][index][key]
            for name, short in ((PAPER, "paper"), (INVERSION, "inversion"), (PREPARED, "ours"))
            for what, key in (("mean", "mean"), ("std", "std"), ("median", "p50"))
        }
        | {"median over median": gains[index]}
        for index, nodes in enumerate(grids)
    ]
    caption = "Times per reading on one core, ours in single precision; last the paper's over ours."
    return Table("times", caption, rows)

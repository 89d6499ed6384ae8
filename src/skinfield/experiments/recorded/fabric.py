"""A fabric taxel pressed beside a force sensor: how well one curve tells force from counts."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats
from skinfield.experiments.recorded.finding import Finding, Value, needed
from skinfield.experiments.words import png_of
from skinfield.figures.real_data import draw_curves

FOLDER = "hrl-fabric-taxel-ft"
RUNS = {"1 cm": "1cm_200ohms_unstretched.csv", "4 cm": "4cm_200ohms_unstretched.csv"}
FOLDS = 5  # stretches of time that are left out in turn
SOURCE = "gt-ros-pkg/hrl-haptic-manip, Apache 2.0"


@dataclass(frozen=True, eq=False)
class FabricRun:
    """Force and counts of one taxel, and a falling curve between them.

    Attributes
    ----------
    force : (T,) array, N
    counts : (T,) array
    predicted : (T,) array, N
        From the counts, by the curve of the other four fifths of the time.
    """

    force: Floats
    counts: Floats
    predicted: Floats

    @property
    def touched(self) -> np.ndarray:
        """Readings that are not at rest, the highest count, (T,)."""
        return np.asarray(self.counts < self.counts.max())

    def rms(self, touched: bool = True) -> float:
        """Error on readings not used in the fit, N; of those that are touched, or at rest."""
        error = (self.predicted - self.force)[self.touched == touched]
        return float(np.sqrt(np.mean(error**2)))

    @property
    def relative(self) -> float:
        """Median of the error over the force where that is above 5 N."""
        pressed = self.force > 5.0
        return float(np.median(np.abs(self.predicted - self.force)[pressed] / self.force[pressed]))

    @property
    def rest_to(self) -> float:
        """Force up to which nine tenths of the readings are at rest, N: the taxel's blind range."""
        return float(np.quantile(self.force[~self.touched], 0.9)) if (~self.touched).any() else 0.0


def load_run(path: Path) -> tuple[Floats, Floats]:
    """Force (T,) N and counts (T,) of a table with lines ``force_N,adc`` below comments.

    Raises
    ------
    FileError
        If the file cannot be read or holds other than two numbers a line; with its line.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"{path} cannot be read as text: {error}") from error
    rows = []
    for number, line in enumerate(lines, start=1):
        if line.startswith("#") or not line.strip():
            continue
        try:
            force, counts = (float(cell) for cell in line.split(","))
        except ValueError as error:
            raise FileError(
                f"{path}:{number} is {line[:40]!r}, expected two numbers: force_N,adc"
            ) from error
        if not (np.isfinite(force) and np.isfinite(counts)):
            raise FileError(f"{path}:{number} is {line[:40]!r}, expected finite numbers")
        rows.append((force, counts))
    if len(rows) < 10 * FOLDS:
        raise FileError(f"{path} has {len(rows)} readings, expected at least {10 * FOLDS}")
    table = np.array(rows)
    return table[:, 0], table[:, 1]


def falling_curve(counts: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Counts and forces of the falling step curve with the least squared error."""
    from scipy.optimize import isotonic_regression

    level, which = np.unique(counts, return_inverse=True)
    weight = np.bincount(which).astype(np.float64)
    mean = np.bincount(which, weights=force) / weight
    return level, np.asarray(isotonic_regression(mean, weights=weight, increasing=False).x)


def judged_on_the_rest(counts: Floats, force: Floats) -> Floats:
    """Force (T,) N of every reading by the curve of the other stretches of time."""
    out = np.empty_like(force)
    stretches = np.array_split(np.arange(len(force)), FOLDS)
    for left_out in stretches:
        used = np.setdiff1d(np.arange(len(force)), left_out)
        out[left_out] = np.interp(counts[left_out], *falling_curve(counts[used], force[used]))
    return out


def fabric_runs(folder: Path) -> dict[str, FabricRun]:
    """Both runs, by the side of the taxel."""
    runs = {}
    for name, file in RUNS.items():
        force, counts = load_run(needed(folder, FOLDER, file))
        runs[name] = FabricRun(force, counts, judged_on_the_rest(counts, force))
    return runs


def fabric_taxel(folder: Path) -> Finding:
    """See `FabricRun`; in words."""
    runs = fabric_runs(folder)

    def figure() -> bytes:
        return png_of(
            draw_curves(
                {
                    f"taxel of {name}": (
                        run.counts,
                        run.force,
                        *falling_curve(run.counts, run.force),
                    )
                    for name, run in runs.items()
                }
            )
        )

    told = [
        f"{name}: {run.rms():.1f} N rms off where it is touched ({run.force.max():.0f} N at most, "
        f"median error {100 * run.relative:.0f} % above 5 N), and silent up to about "
        f"{run.rest_to:.1f} N"
        for name, run in runs.items()
    ]
    sentences = (
        "One falling curve from counts to force, fitted to four fifths of a run and judged on the "
        f"fifth, {FOLDS} times. {'; '.join(told)}.",
        "No model is involved: so much a piezoresistive fabric leaves to any reconstruction that "
        "takes each count by itself, however well it is calibrated.",
    )
    rows: list[dict[str, Value]] = [
        {
            "taxel": name,
            "readings": len(run.force),
            "highest force (N)": round(float(run.force.max()), 1),
            "error where touched, rms (N)": round(run.rms(), 2),
            "error above 5 N, median (%)": round(100 * run.relative, 1),
            "silent up to (N)": round(run.rest_to, 2),
        }
        for name, run in runs.items()
    ]
    return Finding(
        name="fabric",
        title="a fabric taxel beside a force sensor",
        source=SOURCE,
        sentences=sentences,
        rows=tuple(rows),
        figure=figure,
        caption="Counts and force of every reading, and the falling curve of all of them.",
    )

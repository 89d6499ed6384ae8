r"""Calibration by the total normal force on a patch, as of a sensor beneath or a robot's probe.

The force is a Gaussian process of the reading y (kriging with a trend; Rasmussen and Williams 2006,
Gaussian Processes for Machine Learning, chapters 2 and 8.3.1):
:math:`\bar F + s\,(\Sigma - \bar\Sigma) + \sum_m w_m \exp(-d(y, y_m)^2 / 2\ell^2)
+ \sum_k g_k (y_k - \bar y_k)`.
The trend over the sum of counts is held within what the calibration saw, and never falls as the
skin is pressed harder. Readings alike are off alike, so a thousand of a skin that stands still
count as few: d compares patterns y_m blurred over some pitches, and far from all of them the trend
is left, which is what carries over to another recording. The gains g, alike for neighbours, are
taken only where they are better by far: what foretells one recording best seldom does so on the
next, where rest has drifted and other taxels are touched.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.distance import cdist

from skinfield.errors import Floats, InputError, as_floats, check_shape, check_type
from skinfield.skin import Patch

TRIVIAL = ("a constant", "a line over the sum of counts", "ridge regression")
MOST = 1e5  # N: no skin is pressed harder
PARTS = 5  # contiguous parts, of which each is foretold from the others
LEAST = 50  # readings
PATTERNS = 100  # that readings are compared with
LEAST_POWER = 1e-6  # of a mode of the patterns
BLUR, ALIKE = 4.0, 2.0  # pitches, over which patterns are blurred, and gains are alike
LENGTH = 0.4  # over which readings are off alike, of the distance of two readings (rms)
NOISE = 0.03  # of the variance of labels, in their mean over all readings: 33 count, in effect
# Noise, weight of patterns and of gains, and the share of the error of the first of these that
# another's is at most to be taken: the trend alone, and ever softer ones.
PRIORS = (
    (NOISE, 1.0, 0.0, 1.0),
    (NOISE / 1000.0, 0.0, 0.0, 0.85),
    (NOISE / 10.0, 1.0, 1.0, 0.75),
    (NOISE / 100.0, 1.0, 1.0, 0.75),
    (NOISE / 1000.0, 1.0, 1.0, 0.75),
)
LIKE, STRANGE = 0.05, 0.3  # of the distance of two readings: of the same touch, of another
RIDGES = 10.0 ** np.arange(-3.0, 3.0)  # of the ridge regression that it is compared with
ALIKE_RMSE = 0.02  # share by which errors differ that are as good
WORTH = 0.93  # of their deviation, above which labels foretold from mixed others do not follow
TOLD = 1.645 * NOISE**0.5  # correlation whose sign is right at 95 %, of as many as count in effect
STANDS = 3.0  # deviations of labels, below their mean
LEAST_PRESSED = 10.0  # % of readings, at rest if they lie within as much of their span
REST = 0.2  # of labels' deviation: that of labels at rest at most, and the least said of them;
# and of the span of sums, below which they are at rest


@dataclass(frozen=True, eq=False)
class ForceCalibration:
    """Total normal force on a patch from its readings.

    Attributes
    ----------
    mean_force, residual_std : float, N
        Of the labels, and of labels foretold from other parts of the recording: any answer's ±.
    axis : int
        Which of the labels' axes it was.
    sign : int
        1 or -1, by which labels as given are positive in compression.
    correlation : float
        Of labels as given with how far the skin is pressed, by the sum of counts.
    rest_force : float, N
        What labels as given read where the skin is pressed least; NaN if it never rests, or they
        do not agree.
    slope : float, N per count
        Of the sum of counts.
    sums : (3,) array, counts
        Mean, least and most of the sum.
    patterns : (M, L) array, counts
        Readings that others are compared with.
    weights : (M,) array, N
        Of the patterns, around `mean_pattern` (M,).
    length : float, counts
    gain : (L,) array, N per count
        Of each taxel, beside all this.
    mean_reading : (L,) array, counts
        NaN of taxels that did not answer: they are not heard later either.
    places : (L, 2) array, in units of the blur
    constant_rmse, sum_rmse, ridge_rmse : float, N
        Of trivial answers, foretold the same way: the labels' mean, a line over the sum of
        counts, ridge regression of the taxels.
    line_slope : float, N per count
    ridge_gain : (L,) array, N per count
        Of these, fitted to all labels.
    """

    mean_force: float
    residual_std: float
    axis: int
    sign: int
    correlation: float
    rest_force: float
    slope: float
    sums: Floats
    patterns: Floats
    weights: Floats
    mean_pattern: Floats
    length: float
    gain: Floats
    mean_reading: Floats
    places: Floats
    constant_rmse: float
    sum_rmse: float
    ridge_rmse: float
    line_slope: float
    ridge_gain: Floats

    def __post_init__(self) -> None:
        taxels, patterns = len(self.gain), len(self.weights)
        check_shape("sums", self.sums, (3,), "mean, least and most")
        for name in ("mean_reading", "ridge_gain"):
            check_shape(name, getattr(self, name), (taxels,), "one per taxel")
        check_shape("places", self.places, (taxels, 2), "one per taxel")
        check_shape("patterns", self.patterns, (patterns, taxels), "one per weight")
        check_shape("mean_pattern", self.mean_pattern, (patterns,), "one per weight")
        if self.axis not in (0, 1, 2) or not self.length > 0.0:
            raise InputError(
                f"axis is {self.axis} and length {self.length}, expected 0 to 2, and above 0"
            )
        if self.sign not in (-1, 1):
            raise InputError(f"sign is {self.sign}, expected 1 or -1")

    def __len__(self) -> int:
        return len(self.gain)

    @property
    def rmse(self) -> dict[str, float]:
        """Errors of the trivial answers by their names, N."""
        return dict(zip(TRIVIAL, (self.constant_rmse, self.sum_rmse, self.ridge_rmse), strict=True))

    @property
    def sign_is_sure(self) -> bool:
        """Whether the sign of labels is sure."""
        return bool(abs(self.correlation) >= TOLD)

    @property
    def verdict(self) -> str:
        """How good it is, in a sentence."""
        words = [f"parts foretold from the others: {compared(self.residual_std, self.rmse)}"]
        if not self.sign_is_sure:
            words.append(
                f"labels hardly follow the sum of counts (correlation {self.correlation:.2f}): that"
                f" {'positive' if self.sign > 0 else 'negative'} ones press is not sure"
            )
        elif self.sign < 0:
            words.append("labels are turned: they fall as the skin is pressed")
        if abs(self.rest_force) > REST * self.constant_rmse:
            words.append(
                f"labels read about {self.rest_force:.3g} N where the skin is pressed least: if "
                "nothing presses it there, take that off (--offset)"
            )
        return "; ".join(words)

    def __repr__(self) -> str:
        return f"ForceCalibration({self.verdict})"

    def force(self, counts: ArrayLike) -> Floats:
        """Total normal force (T,), N, of readings (T, L); NaN where no taxel answered.

        A taxel that did not answer is taken at its mean. `residual_std` is how far off an answer
        is, if the reading is like those of the calibration.
        """
        table = _table(counts, len(self))
        silent = np.isnan(table).all(axis=1)
        mean = np.nan_to_num(self.mean_reading)
        table = np.where(np.isnan(table + self.mean_reading), mean, table)
        alike = _alike(table, self.patterns, self.places, self.length) - self.mean_pattern
        total = np.clip(table.sum(axis=1), *self.sums[1:]) - self.sums[0]
        beside = (table - mean) @ self.gain
        force = self.mean_force + self.slope * total + alike @ self.weights + beside
        return np.where(silent, np.nan, force)

    def trivial(self, counts: ArrayLike) -> dict[str, Floats]:
        """What trivial answers (T,) make of readings (T, L), by their names, N."""
        off = np.nan_to_num(_table(counts, len(self)) - self.mean_reading)
        answers = (np.zeros(len(off)), self.line_slope * off.sum(axis=1), off @ self.ridge_gain)
        return {name: self.mean_force + each for name, each in zip(TRIVIAL, answers, strict=True)}

    def label(self, labels: Floats) -> Floats:
        """The one (T,) of labels (T,) or (T, 3) that it answers, positive in compression."""
        return self.sign * (labels if labels.ndim == 1 else labels[:, self.axis])


def compared(rmse: float, trivial: Mapping[str, float]) -> str:
    """An error beside those of trivial answers, N, in words."""
    better = [name for name, its in trivial.items() if its < (1.0 - ALIKE_RMSE) * rmse]
    as_good = [
        name
        for name, its in trivial.items()
        if name not in better and its < (1.0 + ALIKE_RMSE) * rmse
    ]
    words = ", ".join(f"{name} {its:.3g}" for name, its in trivial.items())
    for names, how in ((better, "better"), (as_good, "as good")):
        if names:
            words += f"; {' and '.join(names)} {'are' if names[1:] else 'is'} {how}"
    return f"{rmse:.3g} N off (rms), {words}"


class ForceFit(NamedTuple):
    """A calibration, and its labels foretold from other parts (T,), N."""

    calibration: ForceCalibration
    foretold: Floats


def force(patch: Patch, counts: ArrayLike, force: ArrayLike) -> ForceCalibration:
    """Calibrate the total normal force on a patch by labels.

    Parameters
    ----------
    patch : Patch
        Of L taxels.
    counts : (T, L) array
        Readings in any order; where neighbours in time stand together, errors are stated more
        honestly. NaN where a taxel did not answer.
    force : (T,) or (T, 3) array, N
        Of three axes the one that varies most is taken. Labels that fall as the skin is pressed
        are turned: forces are positive in compression. An offset stays in them: `verdict` says
        what they read at rest.

    Returns
    -------
    ForceCalibration

    Raises
    ------
    InputError
        If the arrays do not go together, or the labels do not follow the skin: a sensor that is
        dead reads its own offset whatever presses.
    """
    return fit_force(patch, counts, force).calibration


def fit_force(patch: Patch, counts: ArrayLike, force: ArrayLike) -> ForceFit:
    """The calibration of `force`, and how its labels are foretold."""
    check_type("patch", patch, Patch, "such as layouts.hexagon72()")
    table = _table(counts, len(patch))
    labels = as_floats("force", force)
    axes = (3,) if labels.ndim == 2 else ()
    check_shape("force", labels, (len(table), *axes), "one per reading, or three axes of each")
    if len(table) < LEAST:
        raise InputError(f"counts has {len(table)} readings, expected {LEAST} or more")
    bad = np.argwhere(~np.isfinite(labels))
    if len(bad):
        row = tuple(bad[0].tolist())
        raise InputError(f"force[{row[0]}] is {labels[row]}, expected a number, in N")
    if (largest := float(np.abs(labels).max())) > MOST:
        raise InputError(
            f"force reaches {largest:.3g} N, expected {MOST:g} at most: its unit is a smaller one, "
            "most likely"
        )
    axis = int(np.argmax(labels.std(axis=0))) if axes else 0  # offsets say nothing of the load
    labels = labels[:, axis] if axes else labels
    heard = ~np.isnan(table).all(axis=0)
    mean_reading = np.zeros(len(patch))
    mean_reading[heard] = np.nanmean(table[:, heard], axis=0)
    found = _fit(patch, np.where(np.isnan(table), mean_reading, table), labels, axis)
    known = np.where(heard, found.calibration.mean_reading, np.nan)
    return found._replace(calibration=replace(found.calibration, mean_reading=known))


def _refuse(labels: Floats) -> NoReturn:
    raise InputError(
        f"force, {labels.mean():.3g} N with a deviation of {labels.std():.3g} N, does not follow "
        "the skin: no answer foretells it better than its mean. Expected a load that the skin "
        "feels; a sensor that is dead, or of another limb, reads its own offset"
    )


def _table(counts: ArrayLike, taxels: int) -> Floats:
    table = as_floats("counts", counts)
    check_shape(
        "counts",
        table,
        (None, taxels),
        "readings and taxels of the patch; one reading is counts[None]",
    )
    if np.isinf(table).any():
        row, taxel = np.argwhere(np.isinf(table))[0]
        raise InputError(
            f"counts[{row}, {taxel}] is {table[row, taxel]}, expected a number, or NaN where a "
            "taxel did not answer"
        )
    return table


def _distance(table: Floats, patterns: Floats, places: Floats) -> Floats:
    """Squared distance (T, M) of blurred readings, counts²."""
    blur = np.exp(-0.5 * cdist(places, places, "sqeuclidean"))
    middle = patterns.mean(axis=0)  # small numbers cancel less
    table, patterns = table - middle, patterns - middle
    blurred = patterns @ blur
    squares = np.einsum("tk,tk->t", table @ blur, table)
    own = np.einsum("mk,mk->m", blurred, patterns)
    return np.asarray(np.maximum(squares[:, None] + own - 2.0 * table @ blurred.T, 0.0))


def _alike(table: Floats, patterns: Floats, places: Floats, length: float) -> Floats:
    alike: Floats = np.exp(-0.5 * _distance(table, patterns, places) / length**2)
    return alike


def _direction(table: Floats, labels: Floats) -> float:
    """-1 where pressure lowers counts: taxels agree on their rest, not on how far they go.

    Of a single taxel labels tell that are next to none at one end, without load.
    """

    def disagree(ends: Floats) -> float:
        return float(np.abs(ends - np.median(ends)).mean())

    low, high = disagree(table.min(axis=0)), disagree(table.max(axis=0))
    ends = np.sort(np.abs([labels.min(), labels.max()]))
    if low == high and ends[0] < REST * ends[1]:
        return 1.0 if np.cov(table.sum(axis=1), np.abs(labels))[0, 1] >= 0.0 else -1.0
    if low == high:  # presses are the longer tail
        return 1.0 if np.sum((table - np.median(table, axis=0)) ** 3) >= 0.0 else -1.0
    return 1.0 if low < high else -1.0


def _sign_and_rest(pressed: Floats, labels: Floats) -> dict[str, Any]:
    """Sign, correlation and level at rest of labels (T,), by counts (T, L) that rise when pressed.

    A correlation that may be one by chance tells no sign of a load that stands: the mean does. Rest
    is where the taxel that is pressed most is hardly so: drift of all hides that from their sum.
    """
    total = pressed.sum(axis=1)
    varies = np.ptp(total) > 0.0 and np.ptp(labels) > 0.0
    follows = float(np.corrcoef(total, labels)[0, 1]) if varies else 0.0
    stands = abs(labels.mean()) > STANDS * labels.std()
    told = float(labels.mean()) if stands and abs(follows) < TOLD else follows
    most = (pressed - np.percentile(pressed, LEAST_PRESSED / 2.0, axis=0)).max(axis=1)
    least, low, high = np.percentile(most, [1.0, LEAST_PRESSED, 99.0])
    below, rest, above = np.percentile(labels[most <= low], [16.0, 50.0, 84.0])
    still = low - least < LEAST_PRESSED / 100.0 * (high - least)
    least, high = np.percentile(total, [1.0, 99.0])
    still = still and np.median(total[most <= low]) - least < REST * (high - least)
    agree = above - below < 2.0 * REST * labels.std()
    return {
        "sign": 1 if told >= 0.0 else -1, "correlation": follows,
        "rest_force": float(rest) if still and agree else float("nan"),
    }  # fmt: skip


class _Regression:
    """Least squares in deviations, of all readings or of all but a part, as if never seen."""

    def __init__(self, design: Floats, labels: Floats) -> None:
        self.design, self.labels = design - design.mean(axis=0), labels
        self.gram = self.design.T @ self.design
        self.moment = self.design.T @ (labels - labels.mean())

    def solved(self, penalty: Floats, sense: float = 0.0) -> Floats:
        """Weights by a penalty for each, of one reading; infinite, where there is none."""
        return _solved(self.gram, self.moment, penalty * len(self.labels), sense)

    def foretold(
        self, penalties: list[Floats], parts: list[NDArray[np.int64]], sense: float = 0.0
    ) -> Floats:
        """Labels (N, T) of each part from the others, by each of N penalties.

        With a sense, the first column is held within that of the others.
        """
        left = np.empty((len(penalties), len(self.labels)))
        mean = self.labels.mean()
        for part in parts:
            its, label = self.design[part], self.labels[part] - mean
            held = its.copy()
            if sense:
                others = np.delete(self.design[:, 0], part)
                held[:, 0] = np.clip(held[:, 0], others.min(), others.max())
            rest = len(self.labels) - len(part)
            middle, level = -its.sum(axis=0) / rest, -label.sum() / rest
            gram = self.gram - its.T @ its - rest * np.outer(middle, middle)
            moment = self.moment - its.T @ label - rest * level * middle
            for row, penalty in zip(left, penalties, strict=True):
                weights = _solved(gram, moment, penalty * rest, sense)
                row[part] = mean + level + (held - middle) @ weights
        return left


def _solved(gram: Floats, moment: Floats, penalty: Floats, sense: float) -> Floats:
    """Weights, of which the first is not against `sense`, if that is not 0."""
    weights = np.zeros(len(moment))
    kept = np.flatnonzero(np.isfinite(penalty))
    for _ in range(2):
        weights[kept] = np.linalg.solve(
            gram[np.ix_(kept, kept)] + np.diag(penalty[kept]), moment[kept]
        )
        if weights[0] * sense >= 0.0:
            break
        weights[0], kept = 0.0, kept[1:]
    return weights


class _Design(NamedTuple):
    """What a force is a sum of, by reading."""

    total: Floats
    patterns: Floats
    length: float
    places: Floats
    alike: Floats
    modes: Floats
    root: Floats
    parts: list[NDArray[np.int64]]

    def columns(self, table: Floats) -> Floats:
        """Sum, patterns and gains (T, P), about as large as each other."""
        scale = float(self.total.std()) or 1.0
        beside = (table - table.mean(axis=0)) @ self.root
        return np.hstack([self.total[:, None] / scale, self.alike @ self.modes, beside])


def _design(patch: Patch, table: Floats) -> _Design:
    pitch = patch.pitch if np.isfinite(patch.pitch) else float(np.ptp(patch.plane)) or 1.0
    places = patch.plane / (BLUR * pitch)
    rows = np.linspace(0, len(table) - 1, min(PATTERNS, len(table))).astype(np.int64)
    patterns = table[rows]
    distance = np.sqrt(_distance(table, patterns, places))
    apart = float(np.sqrt(np.square(distance[rows]).mean())) or 1.0
    length = LENGTH * apart
    power, modes = np.linalg.eigh(np.exp(-0.5 * (distance[rows] / length) ** 2))
    near = np.exp(-0.5 * cdist(places, places, "sqeuclidean") * (BLUR / ALIKE) ** 2)
    root = np.asarray(np.linalg.cholesky(near + 1e-6 * np.eye(len(patch))), np.float64)
    smooth = (table - table.mean(axis=0)) @ root
    return _Design(
        total=table.sum(axis=1),
        patterns=patterns,
        length=length,
        places=places,
        alike=np.exp(-0.5 * (distance / length) ** 2),
        modes=modes[:, power > LEAST_POWER] / np.sqrt(power[power > LEAST_POWER]),
        root=root / (float(np.sqrt(np.square(smooth).sum(axis=1).mean())) or 1.0),
        parts=_parts(distance / apart, rows),
    )


def _parts(distance: Floats, rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Parts that are foretold from the others: contiguous, or of like readings if shuffled.

    `distance` (T, M) is that of readings from some of them, `rows`. A reading that has its like,
    but not as its neighbour, is of a touch that stayed, in another order than that of time.
    """
    following = np.where(rows + 1 < len(distance), rows + 1, rows - 1)
    others = distance.copy()
    others[rows, np.arange(len(rows))] = np.inf
    beside = distance[following, np.arange(len(rows))].mean()
    known, touch = np.unique(distance.argmin(axis=1), return_inverse=True)
    if beside > STRANGE and others.min(axis=0).mean() < LIKE and len(known) >= PARTS:
        part = touch * PARTS // len(known)
        return [np.flatnonzero(part == each) for each in range(PARTS)]
    return np.array_split(np.arange(len(distance)), PARTS)


def _fit(patch: Patch, table: Floats, labels: Floats, axis: int) -> ForceFit:
    """Calibration by labels (T,); an InputError where they have nothing to do with the skin."""
    design = _design(patch, table)
    first = 1 + design.modes.shape[1]  # of the gains
    sense = _direction(table, labels)
    seen = _sign_and_rest(sense * table, labels)
    labels = seen["sign"] * labels
    its = _Regression(design.columns(table), labels)
    penalties = []
    for noise, patterns, gains, _ in PRIORS:
        penalties.append(np.full(its.design.shape[1], noise))
        penalties[-1][1:first] = noise / patterns if patterns else np.inf
        penalties[-1][first:] = noise / gains if gains else np.inf
    mixed = [np.arange(start, len(labels), PARTS) for start in range(PARTS)]
    if not _rms(its.foretold(penalties[:1], mixed, sense) - labels)[0] < WORTH * labels.std():
        _refuse(seen["sign"] * labels)
    foretold = its.foretold(penalties, design.parts, sense)
    errors = _rms(foretold - labels)
    allowed = [
        error <= share * errors[0] for error, (*_, share) in zip(errors, PRIORS, strict=True)
    ]
    best = int(np.argmin(np.where(allowed, errors, np.inf)))
    weights = its.solved(penalties[best], sense)
    total = design.total
    made = ForceCalibration(
        mean_force=float(labels.mean()),
        residual_std=errors[best],
        axis=axis,
        **seen,
        slope=float(weights[0]) / (float(total.std()) or 1.0),
        sums=np.array([total.mean(), total.min(), total.max()]),
        patterns=design.patterns,
        weights=design.modes @ weights[1:first],
        mean_pattern=design.alike.mean(axis=0),
        length=design.length,
        gain=design.root @ weights[first:],
        mean_reading=table.mean(axis=0),
        places=design.places,
        **_trivial(table, labels, design.parts),
    )
    return ForceFit(made, foretold[best])


def _trivial(table: Floats, labels: Floats, parts: list[NDArray[np.int64]]) -> dict[str, Any]:
    """What a constant, a line over the sum and ridge regression make of it."""
    span = float(np.ptp(table, axis=0).max()) or 1.0
    change, found = (table - table.mean(axis=0)) / span, []
    for design, ridges in (
        (np.zeros((len(labels), 1)), np.ones(1)),
        (change.sum(axis=1, keepdims=True), np.full(1, 1e-9)),
        (change, RIDGES),
    ):
        its = _Regression(design, labels)
        penalties = [np.full(design.shape[1], ridge) for ridge in ridges]
        errors = _rms(its.foretold(penalties, parts) - labels)
        best = int(np.argmin(errors))
        found.append((errors[best], its.solved(penalties[best]) / span))
    (constant, _), (line, slope), (ridge, gain) = found
    return {
        "constant_rmse": constant, "sum_rmse": line, "ridge_rmse": ridge,
        "line_slope": float(slope[0]), "ridge_gain": gain,
    }  # fmt: skip


def _rms(off: Floats) -> list[float]:
    """Root mean square of each row."""
    return [float(each) for each in np.sqrt(np.square(off).mean(axis=1))]

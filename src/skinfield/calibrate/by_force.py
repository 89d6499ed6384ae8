r"""Calibration by the total normal force on a patch, as of a sensor beneath or a robot's probe.

The force is :math:`\bar F + \sum_k w_k (f_k - \bar f_k) + \sum_l g_l (y_l - \bar y_l)`: a few
figures f of each reading y (its sum, its highest, how many taxels are touched, where) and a gain of
each taxel, a Gaussian process over the patch, so that gains are drawn towards those of neighbours
and what no taxel feels towards the mean of the labels (Rasmussen and Williams 2006, Gaussian
Processes for Machine Learning, chapter 2). These priors are stiff: what foretells some parts of a
recording best from the others does seldom so on the next, where other taxels are touched. Softer
ones are taken where they are better by far.
"""

from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.distance import cdist

from skinfield.errors import Floats, InputError, as_floats, check_shape
from skinfield.skin import Patch

PARTS = 5  # contiguous parts, of which each is foretold from the others
LEAST = 50  # readings
LENGTH = 2.0  # pitches, over which gains are alike
# What priors of figures, and of gains, weigh beside all labels together; the stiffest first.
PRIORS = ((1.0, 5.0), (0.1, 0.3), (0.03, 0.03), (0.03, 0.003))
BETTER = 0.8  # of the error of the stiffest, that the error of a softer one is at most
RIDGES = 10.0 ** np.arange(-3.0, 3.0)  # of the ridge regression that it is compared with
FIGURES = 7
FOLLOWS = 0.9  # of the error of a constant, that one of three axes is foretold by at most
WORTH = 0.97  # of their deviation, above which labels foretold from mixed others do not follow
REST = 10.0  # percent of readings, in which a taxel is hardly touched
TOUCHED = 0.02  # of the range of counts, from which on a taxel counts as touched


@dataclass(frozen=True, eq=False)
class ForceCalibration:
    """Total normal force on a patch from its readings.

    Attributes
    ----------
    gain : (L,) array, N per count
        By which a taxel's count moves the force, beside the figures of the whole reading.
    weights : (F,) array, N
        Of the figures, in their deviations.
    mean_force, residual_std : float, N
        Of the labels, and of the labels foretold from other parts.
    rest, mean_reading : (L,) array, counts
    scale : (2, F) array
        Mean and deviation of the figures.
    places : (L, 2) array, in the patch's extent
    direction : float
        -1 where pressure lowers the counts.
    span : float, counts
        From rest to the highest reading.
    constant_rmse, sum_rmse, ridge_rmse : float, N
        Of trivial answers, foretold the same way: the labels' mean, a line over the sum of
        counts, ridge regression of the taxels.
    """

    gain: Floats
    weights: Floats
    mean_force: float
    residual_std: float
    rest: Floats
    mean_reading: Floats
    scale: Floats
    places: Floats
    direction: float
    span: float
    constant_rmse: float
    sum_rmse: float
    ridge_rmse: float

    def __post_init__(self) -> None:
        taxels = len(self.gain)
        for name in ("rest", "mean_reading"):
            check_shape(name, getattr(self, name), (taxels,), "one per taxel")
        check_shape("places", self.places, (taxels, 2), "one per taxel")
        check_shape("weights", self.weights, (FIGURES,), "one per figure")
        check_shape("scale", self.scale, (2, FIGURES), "mean and deviation of the figures")

    def __len__(self) -> int:
        return len(self.gain)

    @property
    def verdict(self) -> str:
        """How good it is, in a sentence."""
        trivial = {
            "a constant": self.constant_rmse,
            "a line over the sum of counts": self.sum_rmse,
            "ridge regression": self.ridge_rmse,
        }
        better = [name for name, rmse in trivial.items() if rmse < self.residual_std]
        words = ", ".join(f"{name} {rmse:.3g}" for name, rmse in trivial.items())
        end = f"; {' and '.join(better)} is better" if better else ""
        return (
            f"{self.residual_std:.3g} N off (rms, parts foretold from the others); {words} N{end}"
        )

    def __repr__(self) -> str:
        return f"ForceCalibration({self.verdict})"

    def force(self, counts: ArrayLike) -> Floats:
        """Total normal force (T,), N, of readings (T, L); NaN where no taxel answered.

        A taxel that did not answer is taken at its mean.
        """
        table = _table(counts, len(self))
        silent = np.isnan(table).all(axis=1)
        table = np.where(np.isnan(table), self.mean_reading, table)
        figures = _figures(self.direction * (table - self.rest), self.span, self.places)
        off = (figures - self.scale[0]) / self.scale[1]
        force = self.mean_force + off @ self.weights + (table - self.mean_reading) @ self.gain
        return np.where(silent, np.nan, force)


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
        Into the skin; of three axes the strongest is taken, whatever its sign.

    Returns
    -------
    ForceCalibration

    Raises
    ------
    InputError
        If the arrays do not go together, or the labels do not follow the skin: a sensor that is
        dead reads its own offset whatever presses.
    """
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
    found = [_known(patch, table, np.sign(axis.mean()) * axis) for axis in labels.T] if axes else []
    if not axes:
        made = _known(patch, table, labels)
    elif any(each and each.residual_std < FOLLOWS * each.constant_rmse for each in found):
        made = found[int(np.argmax(np.square(labels).mean(axis=0)))]  # loads press
    else:
        made = None
    if made is None:
        _refuse(labels[:, 0] if axes else labels)
    return made


def _refuse(labels: Floats) -> NoReturn:
    raise InputError(
        f"force, {labels.mean():.3g} N with a deviation of {labels.std():.3g} N, does not follow "
        "the skin: no answer foretells it better than its mean. Expected a load that the skin "
        "feels; a sensor that is dead, or of another limb, reads its own offset"
    )


def _table(counts: ArrayLike, taxels: int) -> Floats:
    table = as_floats("counts", counts)
    check_shape("counts", table, (None, taxels), "readings and taxels of the patch")
    if np.isinf(table).any():
        row, taxel = np.argwhere(np.isinf(table))[0]
        raise InputError(
            f"counts[{row}, {taxel}] is {table[row, taxel]}, expected a number, or NaN where a "
            "taxel did not answer"
        )
    return table


def _figures(pressed: Floats, span: float, places: Floats) -> Floats:
    """Sum, number, highest, norm, place and log of sum (T, F) of readings (T, L) from rest."""
    share = np.maximum(pressed, 0.0) / span
    total = share.sum(axis=1)
    middle = share @ places / np.maximum(total, 1e-9)[:, None]
    number = (share > TOUCHED).sum(axis=1)
    return np.column_stack(
        [total, number, share.max(axis=1), np.sqrt(np.square(share).sum(axis=1)), middle,
         np.log(total + TOUCHED)]
    )  # fmt: skip


def _known(patch: Patch, table: Floats, labels: Floats) -> ForceCalibration | None:
    """Calibration by labels (T,), None where they do not follow the skin."""
    heard = ~np.isnan(table).all(axis=0)
    mean_reading = np.zeros(len(patch))
    mean_reading[heard] = np.nanmean(table[:, heard], axis=0)
    table = np.where(np.isnan(table), mean_reading, table)
    away = table - np.median(table, axis=0)
    direction = 1.0 if np.sum(away**3) >= 0.0 else -1.0  # presses are the longer tail
    rest = direction * np.percentile(direction * table, REST, axis=0)
    span = max(float(np.max(direction * (table - rest))), 1e-9)
    extent = float(np.ptp(patch.plane, axis=0).max()) or 1.0
    places = (patch.plane - patch.plane.min(axis=0)) / extent
    figures = _figures(direction * (table - rest), span, places)
    scale = np.stack([figures.mean(axis=0), figures.std(axis=0) + 1e-9])
    off, change = (figures - scale[0]) / scale[1], (table - mean_reading) / span
    length = LENGTH * (patch.pitch if np.isfinite(patch.pitch) else extent)
    apart = cdist(patch.plane, patch.plane, "sqeuclidean") / length**2
    root = np.linalg.cholesky(np.exp(-0.5 * apart) + 1e-6 * np.eye(len(patch)))
    smooth = change @ root
    parts = np.array_split(np.arange(len(labels)), PARTS)
    mixed = [np.arange(first, len(labels), PARTS) for first in range(PARTS)]
    designs = [np.hstack([off / np.sqrt(f), smooth / np.sqrt(g)]) for f, g in PRIORS]
    if not _error(designs[-1], labels, 1.0, mixed) < WORTH * float(labels.std()):
        return None
    errors = [_error(design, labels, 1.0, parts) for design in designs]
    best = int(np.argmin(errors))
    best = best if errors[best] < BETTER * errors[0] else 0
    solved = _solve(designs[best], labels, 1.0)[0] / np.sqrt(PRIORS[best][1])
    total = direction * (table - rest).sum(axis=1, keepdims=True)
    return ForceCalibration(
        gain=root @ solved[FIGURES:] / span,
        weights=solved[:FIGURES] * np.sqrt(PRIORS[best][1] / PRIORS[best][0]),
        mean_force=float(labels.mean()),
        residual_std=errors[best],
        rest=rest,
        mean_reading=mean_reading,
        scale=scale,
        places=places,
        direction=direction,
        span=span,
        constant_rmse=_error(np.zeros((len(labels), 1)), labels, 1.0, parts),
        sum_rmse=_error(total / (total.std() + 1e-9), labels, 1e-6, parts),
        ridge_rmse=min(_error(change, labels, each, parts) for each in RIDGES),
    )


def _solve(design: Floats, labels: Floats, ridge: float) -> tuple[Floats, Floats, float]:
    """Weights, mean row and mean label of a regression in deviations; a prior as a reading's."""
    middle, mean = design.mean(axis=0), float(labels.mean())
    centred = design - middle
    gram = centred.T @ centred + ridge * len(labels) * np.eye(design.shape[1])
    return np.linalg.solve(gram, centred.T @ (labels - mean)), middle, mean


def _error(design: Floats, labels: Floats, ridge: float, parts: list[NDArray[np.int64]]) -> float:
    """Root mean square of labels less what the other parts foretell of them."""
    left = np.empty(len(labels))
    for part in parts:
        others = np.ones(len(labels), np.bool_)
        others[part] = False
        weights, middle, mean = _solve(design[others], labels[others], ridge)
        left[part] = labels[part] - mean - (design[part] - middle) @ weights
    return float(np.sqrt(np.mean(np.square(left))))

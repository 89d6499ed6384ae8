"""Learn how large an area n fingers touch: makes src/skinfield/solve/atoms/fingers.csv.

    python benchmarks/learn_fingers.py FOLDER LAYOUT [-o fingers.csv]

FOLDER holds CySkin recordings as {n}_finger/sample_XX.txt, 3 s each, of a hand with n fingers laid
down, as in the public repository ladylou899/ros2_ws_cyskin_project (src/cyskin_acquisition/data),
whose samples with odd numbers were taken; LAYOUT is its curved_gesture_patch_full_isomap.json.
Fingers on their tips are drawn at random: round to oval, 14 to 50 mm from each other.

Prints how many recordings are counted right, each by what was learnt from others: the median of
the nine strongest readings.
"""

import argparse
from pathlib import Path

import numpy as np

from skinfield.cli import options
from skinfield.cli.reconstruct_jobs import JobPlan, place_of, take_in
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.compiled import njit
from skinfield.files.results import read_results
from skinfield.solve.atoms import fingers_kernel as kernel
from skinfield.solve.atoms.strips_kernel import MOST, Strips, gather_touched

STRONGEST = 9  # readings of a recording
SHARED = 0.7  # of a class's covariance that is its own; the rest is that of all classes of its pose
JITTER = 2e-3  # variance of logarithms, beside what samples show
TIPS = 120  # drawn scenes of each number
THICKNESS = 2e-3  # m, the unit of places: any


@njit
def figures(places, readings, noise, strips, out):
    """Write figures of each hand of a reading into `out`; how many there are."""
    touched, _ = gather_touched(places, readings, 0.0, noise, strips)
    if touched == 0 or touched == MOST:
        return 0
    hands, taxels = strips.hands, strips.tables[0]
    apart = 1e3 * kernel.HANDS_APART / hands.unit
    count = min(kernel.number_parts(places, taxels, touched, apart, hands.parts[0]), len(out))
    kernel.number_parts(places, taxels, touched, kernel.ISLANDS_APART * hands.pitch, hands.parts[1])
    found = 0
    for hand in range(count):
        size = kernel.measure_hand(places, readings, 0.0, taxels, touched, hand, hands)
        if size > 1 or count == 1:
            out[found] = hands.figures
            found += 1
    return found


def recordings(folder, layout):
    """Fingers, and figures of the strongest readings, of each recording; the plane's places."""
    plan = JobPlan.of(layout, None, options.CountSettings(), Elastomer(), ModelSettings())
    plane = np.asarray(plan.patch.plane)
    strips, out = Strips.of(plane / THICKNESS, THICKNESS), np.zeros((12, kernel.FIGURES))
    found = []
    for path in sorted(Path(folder).glob("*_finger/*.txt")):
        with place_of(None) as place:
            take_in(str(path), plan, place, quiet=True)
            results = read_results(place.part)
            values, noise = results.values(0, len(results)), results.config.noise_std
            values = np.nan_to_num(np.asarray(values))
        rows = []
        for reading in np.argsort(-values.sum(axis=1))[:STRONGEST]:
            count = figures(plane / THICKNESS, values[reading], noise, strips, out)
            rows.append(out[:count].copy())
        found.append((int(path.parent.name.split("_")[0]), rows))
    return found, plane


def tips(plane, seed):
    """Figures of fingers on their tips at places (L, 2) m: (fingers, figures) of each scene."""
    rng, places = np.random.default_rng(seed), plane / THICKNESS
    strips, out = Strips.of(places, THICKNESS), np.zeros((12, kernel.FIGURES))
    noise, found = np.full(len(plane), 4e-3), []
    while len(found) < 5 * TIPS:
        fingers, apart = 1 + len(found) % 5, rng.uniform(0.014, 0.05)
        at = plane[rng.integers(len(plane))] + rng.uniform(-1.2 * apart, 1.2 * apart, (fingers, 2))
        between = np.linalg.norm(at[:, None] - at, axis=-1) + np.eye(fingers)
        away = np.linalg.norm(plane[:, None] - at, axis=-1).min(axis=0)
        if (fingers > 1 and between.min() < apart) or away.max() > 4e-3:
            continue
        readings = rng.normal(0.0, 4e-3, len(plane))
        for tip in at:
            turn, wide, size = rng.uniform(0, np.pi), rng.uniform(1, 1.6), rng.uniform(3.5e-3, 7e-3)
            turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            over = (plane - tip) @ turned / size / [wide**0.5, wide**-0.5]
            readings += rng.uniform(0.3, 0.7) * np.exp(-0.5 * (over**2).sum(axis=1))
        readings *= np.exp(0.15 * rng.standard_normal(len(plane)))
        if figures(places, readings, noise, strips, out) == 1:
            found.append((fingers, out[:1].copy()))
    return found


def learn(poses):
    """Table of classes from the samples of each pose: (fingers, figures (N, FIGURES)) of each."""
    table = []
    for samples in poses:
        rows = [(fingers, row) for fingers, several in samples for row in several]
        numbers = np.array([fingers for fingers, _ in rows])
        values = np.array([row for _, row in rows])
        kinds = np.unique(numbers)
        own = [np.cov(values[numbers == n].T) + JITTER * np.eye(kernel.FIGURES) for n in kinds]
        for n, covariance in zip(kinds, own, strict=True):
            shared = SHARED * covariance + (1.0 - SHARED) * np.mean(own, axis=0)
            table.append([n, *values[numbers == n].mean(axis=0), *shared.ravel()])
    return np.array(table)


def count(table, rows):
    """Fingers of a reading by its hands' figures; 0 where it is not as hands touch."""
    numbers, means = table[:, 0], table[:, 1 : 1 + kernel.FIGURES]
    inverse = np.linalg.inv(table[:, 1 + kernel.FIGURES :].reshape(len(table), kernel.FIGURES, -1))
    half = 0.5 * np.linalg.slogdet(inverse)[1]
    total = 0
    for row in rows:
        away = row - means
        square = np.einsum("ci,cij,cj->c", away, inverse, away)
        if square.min() > kernel.UNLIKE:
            return 0
        total += int(numbers[np.argmax(half - 0.5 * square)])
    return total


def single(found):
    """Samples of recordings whose readings have one hand."""
    return [(n, row) for n, rows in found if n > 0 for row in rows if len(row) == 1]


def validate(found, drawn, folds=5, repeats=4):
    """Print how many recordings are counted right by what others teach."""
    touched, right, error = [each for each in found if each[0] > 0], [], []
    for repeat in range(repeats):
        fold = np.random.default_rng(repeat).permutation(len(touched)) % folds
        for k in range(folds):
            table = learn([single([touched[i] for i in np.flatnonzero(fold != k)]), drawn])
            for i in np.flatnonzero(fold == k):
                fingers, rows = touched[i]
                answer = int(np.median([count(table, row) for row in rows]))
                right.append(answer == fingers)
                error.append(abs(answer - fingers))
    print(f"right {np.mean(right):.3f}, mean error {np.mean(error):.3f}, {len(touched)} recordings")


def main():
    """Learn, validate, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("layout")
    parser.add_argument("-o", default=str(kernel.TABLE))
    arguments = parser.parse_args()
    found, plane = recordings(arguments.folder, arguments.layout)
    drawn, fresh = tips(plane, 1), tips(plane, 2)
    validate(found, drawn)
    table = learn([single(found), drawn])
    right = [count(table, rows) == fingers for fingers, rows in fresh]
    print(f"on tips, drawn: right {np.mean(right):.3f}")
    np.savetxt(arguments.o, table, "%.5g", ",")


if __name__ == "__main__":
    main()

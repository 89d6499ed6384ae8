"""How far repaired taxels are off, and how far σ says: taxels are knocked out one at a time.

    python benchmarks/repair.py                              # virtual skins with all habits
    python benchmarks/repair.py RECORDING ... --layout FILE  # one of the strongest readings of each

Prints the shares of truths within one and two σ, and errors beside the mean of the neighbours: of
taxels with a touched neighbour (`in`; by more than a tenth of the highest reading), and of others.
"""

import argparse

import numpy as np

import skinfield as sf
from skinfield.cli import options
from skinfield.cli.reconstruct_jobs import JobPlan, place_of, take_in
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.files.results import read_results
from skinfield.lab.habit_cases import HabitCases
from skinfield.skin.generators import by_name

SOLVERS = {"contacts": sf.Auto(), "linear": sf.GaussianField(), "field": sf.NonNegative()}
SKIN = "rectangular:rows=14,columns=14,pitch_mm=6"


def recorded(paths, layout, rng):
    """Patch, layer, noise and a reading of each recording, conditioned as the command does."""
    counts, elastomer = options.CountSettings(), Elastomer()
    plan = JobPlan.of(layout, None, counts, elastomer, ModelSettings())
    for path in paths:
        with place_of(None) as place:
            take_in(path, plan, place, quiet=True)
            results = read_results(place.part)
            values, made = np.asarray(results.values(0, len(results))), results.config
        strongest = np.argsort(-np.nan_to_num(values).sum(axis=1))[: min(9, len(values))]
        yield made.patch, made.layer, np.asarray(made.noise_std), values[rng.choice(strongest)]


def simulated(count, seed):
    """The same of virtual skins that one to five soft fingers touch."""
    for case in HabitCases(patch=by_name(SKIN)).cases(count, seed, 1):
        if case.truth.contacts:
            noise = np.broadcast_to(case.noise_std, len(case.patch)).copy()
            yield case.patch, case.layer, noise, np.atleast_2d(case.readings)[0]


def knocked_out(scene, each, rng):
    """Rows of (in, solver, what it read, mean of neighbours, repair, σ) of some taxels."""
    patch, layer, noise, reading = scene
    apart = np.linalg.norm(patch.plane[:, None] - patch.plane, axis=-1)
    near = (apart < 1.3 * np.median(np.sort(apart, axis=1)[:, 1])) & np.isfinite(reading)
    np.fill_diagonal(near, False)
    strength = np.abs(np.nan_to_num(reading))
    floor = max(5 * np.median(noise), 0.1 * strength.max())
    inside = (near & (strength > floor)).any(axis=1)
    recs = {
        name: sf.Reconstructor(patch, layer, noise_std=noise, solver=solver)
        for name, solver in SOLVERS.items()
    }
    for within, most in ((True, each), (False, each // 3)):
        known = np.flatnonzero((inside == within) & np.isfinite(reading) & near.any(axis=1))
        for taxel in rng.permutation(known)[:most]:
            lost = reading.copy()
            lost[taxel] = np.nan
            for name, rec in recs.items():
                rec.reset()
                found = rec(lost)
                repair = found.readings[taxel], found.readings_std[taxel]
                yield within, name, reading[taxel], reading[near[taxel]].mean(), *repair


def rms(values):
    """Root of the mean square."""
    return np.sqrt(np.mean(np.square(values)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("recordings", nargs="*")
    parser.add_argument("--layout")
    parser.add_argument("--scenes", type=int, default=36)
    parser.add_argument("--each", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng, rows = np.random.default_rng(given.seed), []
    scenes = simulated(given.scenes, given.seed)
    if given.recordings:
        scenes = recorded(given.recordings, given.layout, rng)
    for scene in scenes:
        rows += knocked_out(scene, given.each, rng)
    print("taxels    solver    number  1 σ    2 σ    median  rms     neighbours' median  rms")
    for within in (True, False):
        for name in SOLVERS:
            some = np.array([row[2:] for row in rows if row[:2] == (within, name)], float)
            truth, mean, repair, std = some.T
            off, others = np.abs(repair - truth), np.abs(mean - truth)
            shares = [np.mean(off < times * std) for times in (1, 2)]
            errors = [f(each) for each in (off, others) for f in (np.median, rms)]
            words = [f"{value:<6.3f}" for value in shares], [f"{value:<7.4f}" for value in errors]
            print(f"{'in' if within else 'out':9} {name:9} {len(off):<7}", *words[0], *words[1])


if __name__ == "__main__":
    main()

"""`skinfield cases`: write a set of cases to judge solvers by."""

from pathlib import Path
from typing import Annotated

from skinfield.cli import options, report
from skinfield.emulator.settings import NO_HABITS, HabitsName
from skinfield.errors import FileError, InputError
from skinfield.plot import plural
from skinfield.settings import Range

KINDS = 22
Number = Annotated[int | None, Range(1, 10_000, "cases")]


def cases(
    folder: str,
    /,
    *,
    count: Number = None,
    unseen: Number = None,
    habits: HabitsName = NO_HABITS,
    seed: options.Seed = 0,
    layout: options.LayoutText = "hexagon72",
    patch: options.PatchName = None,
    quantity: options.Reads = "capacitance",
    noise: options.Noise = None,
    draws: Annotated[int, Range(0, 10_000, "readings per case")] = 4,
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    """Write simulated cases into the DIR FOLDER, for 'skinfield validate'.

    Balls, flat cylinders, a ring, a bar and a cone, one to three at once, on elastomers of several
    thicknesses and Poisson's ratios, each at a place and an angle of its own: 22 kinds in turn. The
    truth comes from the contact solver; the same seed gives the same files. What is in them, so
    that you can write your own, is in docs/how-to/judge-a-solver.md.

    With --unseen they are random presses instead, one to three bodies on one elastomer: balls of 2
    to 15 mm radius above all, cones, flats, bars and rings.

    With --habits real they are no to five soft fingers in turn, each on a skin of its own that is
    not quite as it is stated: counts of a board that clips at rest, with noise, faults, creep and
    what else real skins do, conditioned as recordings are.

      skinfield cases cases
      skinfield cases cases --count 44 --seed 7 --quantity stress --noise 400 --draws 10
      skinfield cases unseen --unseen 200 --skin icub_hexagon --draws 0
      skinfield cases fingers --habits real --skin rectangular:rows=24,columns=24,pitch_mm=6

    Parameters
    ----------
    folder : str
        DIR to write into.
    count : int, optional
        Of cases. Default 22.
    unseen : int, optional
        So many random presses instead.
    habits : str
        Of the skin: none, or real.
    draws : int
        Noisy readings per case; 0 for one without noise.
    """
    from skinfield.lab.case_files import save_case
    from skinfield.lab.case_sets import random_cases, standard_cases
    from skinfield.lab.habit_cases import HabitCases
    from skinfield.simulate.habits import habits_by_name

    if unseen is not None and count is not None:
        raise InputError(
            f"--count is {count} beside --unseen {unseen}, expected one of them: both are numbers "
            "of cases"
        )
    if habits != NO_HABITS:
        odd = {"--unseen": unseen, "--noise": noise, "--quantity": quantity != "capacitance"}
        for flag, value in odd.items():
            if value:
                raise InputError(
                    f"{flag} beside --habits {habits}, expected none: its skins send counts of "
                    "fingers, with a noise of their own"
                )
    total = unseen or count or KINDS
    taxels = options.patch_of(options.skin_from_text(layout), patch)
    place = _prepared(Path(folder), force)
    if habits != NO_HABITS:
        made = HabitCases(patch=taxels, habits=habits_by_name(habits)).cases(total, seed, draws)
    else:
        make = standard_cases if unseen is None else random_cases
        made = make(taxels, total, seed, quantity, noise, draws)
    written = []
    with report.progress("pressing", total) as step:
        for case in made:
            written.append(str(place / f"{case.name}.npz"))
            save_case(case, written[-1])
            step()
    lines = [f"wrote {plural(total, 'case')} to {folder}"]
    report.finish(as_json, {"folder": folder, "files": written}, lines=lines)


def _prepared(folder: Path, force: bool) -> Path:
    """The folder, without cases of another set: they would be scored with the new ones."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        before = sorted(folder.glob("*.npz"))
        for file in before if force else ():
            file.unlink()
    except (OSError, ValueError) as error:
        raise FileError(f"{folder} cannot be made: {error}, expected a new folder") from error
    if before and not force:
        raise FileError(
            f"{folder} holds {plural(len(before), 'NPZ file')} such as {before[0].name}, "
            "expected a folder without: take a new one, or remove them with --force"
        )
    return folder

"""`skinfield cases`: write a set of cases to judge solvers by."""

from pathlib import Path

import click

from skinfield.cli.inputs import skin_from_text
from skinfield.cli.options import QUANTITIES, patch_of
from skinfield.cli.report import console, plural, progress
from skinfield.errors import FileError, InputError, check_positive


@click.command(
    short_help="Write simulated cases to judge solvers by.",
    help="""Write simulated cases into FOLDER, for 'skinfield validate'.

Balls, flat cylinders, a ring, a bar and a cone, one to three at once, on elastomers of several
thicknesses and Poisson's ratios, each at a place and an angle of its own: 22 kinds in turn. The
truth comes from the contact solver; the same seed gives the same files. docs/cases.md says what is
in them, so that you can write your own.

With --unseen they are random presses instead, one to three bodies on one elastomer: balls of 2 to
15 mm radius above all, cones, flats, bars and rings.

\b
  skinfield cases cases
  skinfield cases cases --count 44 --seed 7 --quantity stress --noise 400 --draws 10
  skinfield cases unseen --unseen 200 --layout icub_hexagon --draws 0
""",
)
@click.argument("folder")
@click.option(
    "--count", type=click.IntRange(1, 10_000), default=22, show_default=True, help="Of cases."
)
@click.option("--unseen", type=click.IntRange(1, 10_000), help="So many random presses instead.")
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of places and noise."
)
@click.option("--layout", default="hexagon72", show_default=True, help="Layout file or generator.")
@click.option("--patch", "patch_name", help="Which patch, where the layout has several.")
@click.option(
    "--quantity",
    type=click.Choice(list(QUANTITIES)),
    default="capacitance",
    show_default=True,
    help="What a taxel reads.",
)
@click.option("--noise", type=float, help="Of a reading, in the quantity's unit. Default typical.")
@click.option(
    "--draws",
    type=click.IntRange(0, 10_000),
    default=4,
    show_default=True,
    help="Noisy readings per case; 0 for one without noise.",
)
@click.option("--replace", is_flag=True, help="Remove the NPZ files that FOLDER holds.")
@click.pass_context
def cases(
    context: click.Context,
    /,
    folder: str,
    count: int,
    unseen: int | None,
    seed: int,
    layout: str,
    patch_name: str | None,
    quantity: str,
    noise: float | None,
    draws: int,
    replace: bool,
) -> None:
    """Make and write cases."""
    from skinfield.experiments.cases.files import save_case
    from skinfield.experiments.cases.standard import standard_cases
    from skinfield.experiments.cases.unseen import unseen_cases

    given = context.get_parameter_source("count") is click.core.ParameterSource.COMMANDLINE
    if unseen is not None and given:
        raise InputError(
            f"--count is {count} beside --unseen {unseen}, expected one of them: both are numbers "
            "of cases"
        )
    if noise is not None:
        check_positive("--noise", noise, "no reading is exact")
    patch = patch_of(skin_from_text(layout), patch_name)
    place = _prepared(Path(folder), replace)
    make, count = (standard_cases, count) if unseen is None else (unseen_cases, unseen)
    with progress() as bar:
        task = bar.add_task("pressing", total=count)
        for case in make(patch, count, seed, quantity, noise, draws):
            save_case(case, place / f"{case.name}.npz")
            bar.update(task, advance=1)
    console().print(
        f"wrote {plural(count, 'case')} to {folder}", highlight=False, soft_wrap=True, markup=False
    )


def _prepared(folder: Path, replace: bool) -> Path:
    """The folder, without cases of another set: they would be scored with the new ones."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        before = sorted(folder.glob("*.npz"))
        for file in before if replace else ():
            file.unlink()
    except (OSError, ValueError) as error:
        raise FileError(f"{folder} cannot be made: {error}, expected a new folder") from error
    if before and not replace:
        raise FileError(
            f"{folder} holds {plural(len(before), 'NPZ file')} such as {before[0].name}, expected "
            "a folder without: take a new one, or remove them with --replace"
        )
    return folder

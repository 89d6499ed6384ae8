"""`skinfield experiments`: the paper's campaign as one command."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Literal

from skinfield.cli.options import OUTPUT, Json, Seed, Workers, processes
from skinfield.cli.report import finish, progress, table
from skinfield.errors import SkinfieldError


def experiments(
    *,
    output: Annotated[str, OUTPUT] = "experiments",
    size: Literal["smoke", "short", "full"] = "short",
    only: str = "",
    workers: Workers = None,
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Make every figure of the paper anew, with its method and with ours, against simulated truth.

    On the half-space and on the layer; it writes one HTML page that needs nothing else, and PNG,
    CSV and JSON files of each part beside it.

    Parts that an earlier run with the same settings left in the folder are taken as they are: a run
    that was stopped goes on where it was.

      skinfield experiments -o report
      skinfield experiments --size smoke --only fig3,fig6

    Parameters
    ----------
    output : str
        DIR of the report.
    size : str
        How much is computed.
    only : str
        Such as fig3,fig6: these parts alone.
    """
    from skinfield.lab.experiments import chosen, run
    from skinfield.lab.report import PAGE, SIZES

    wanted, folder = chosen(only.split(",")), Path(output)
    with progress("experiments", len(wanted)) as step:
        made = run(
            wanted,
            replace(SIZES[size], seed=seed),
            folder,
            processes(workers),
            lambda name, done, total: step(done, total, name or "experiments"),
        )
    page = str(folder / PAGE)
    verdicts = [asdict(verdict) for section in made.sections for verdict in section.verdicts]
    columns = ("figure", "the paper says", "measured here", "verdict")
    shown = table(None, columns, (), show_lines=True)
    for verdict in verdicts:
        shown.add_row(*verdict.values())
    finish(as_json, {"page": page, "verdicts": verdicts}, [page], [shown] if verdicts else [])
    if made.failures:
        named = ", ".join(f"{name} (see {folder / name}.failed.txt)" for name in made.failures)
        raise SkinfieldError(f"the report lacks what failed: {named}")

"""`skinfield cases` and `validate`: cases whose truth is known, and scores of solvers on them."""

import json
import math
import pkgutil
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from rich.box import SIMPLE_HEAD
from rich.console import Console

import skinfield as sf
from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.emulator.settings import NO_HABITS, HabitsName
from skinfield.errors import FileError, InputError
from skinfield.plot import plural
from skinfield.settings import Positive, Range

WIDE = 190  # columns of the terminal that a table of several noises takes
Rows = list[dict[str, Any]]
WorldName = Literal[
    "as-stated", "sticking", "slipping", "friction", "nu-0.49", "nu-0.45", "nu-0.40", "cover",
    "creep-0.1s", "creep-1s", "released-0.1s",
    "creep-0.1s-stated", "creep-1s-stated", "released-0.1s-stated",
]  # fmt: skip
COLUMNS = (  # of the summary's rows
    Column("force\n%", "force_error", 100.0, 0),
    Column("place\nmm", "place_error_mm", 1.0, 2),
    Column("contact\nforce %", "contact_force_error", 100.0, 0),
    Column("total\nforce %", "total_force_error", 100.0, 0),
    Column("peak\n%", "peak_error", 100.0, 0),
    Column("blurred\npress. %", "blurred_pressure_error", 100.0, 0),
    Column("deform.\n%", "deformation_error", 100.0, 0),
    Column("area\n%", "area_error", 100.0, 0),
    Column("force in\ninterval %", "force_held", 100.0, 0),
    Column("missed\n%", "missed", 100.0, 0),
    Column("false per\nreading", "false_per_reading", 1.0, 2),
    Column("number\nright %", "count_right", 100.0, 0),
    Column("idle\ntouched %", "idle_touched", 100.0, 0),
    Column("in noise\nalone", "idle_false_per_reading", 1.0, 4),
    Column("cold\nms", "cold_ms", 1.0, 1),
    Column("warm\nms", "warm_ms", 1.0, 2),
)
EACH = (  # of the rows by case
    Column("case", "case"), Column("solver", "method"), Column("noise", "noise", decimals=0),
    Column("true N", "true_force_N", decimals=2), Column("force", "force_error", decimals=2),
    Column("place mm", "place_error_mm", decimals=2),
    Column("pressure, blurred", "blurred_pressure_error", decimals=2),
    Column("deformation", "deformation_error", decimals=2),
    Column("missed", "missed", decimals=0), Column("false", "false", decimals=0),
)  # fmt: skip


def validate(
    cases: str | None = None,
    /,
    *,
    solver: tuple[str, ...] = (),
    settings: str = "{}",
    mechanics: Literal["case", "layer", "covered-layer", "half-space"] = "case",
    grid: Annotated[int, Range(2, 500, "nodes on a side")] = 40,
    gate_mm: Annotated[float, Positive("distance of contacts that are the same, in mm")] = 8.0,
    noise: Annotated[tuple[float, ...], Range(0.0, 1e12, "0: none")] = (),
    unseen: Annotated[int | None, Range(1, 100_000, "random presses")] = None,
    quantity: tuple[Literal["capacitance", "stress"], ...] = (),
    layout: options.LayoutText = "icub_hexagon",
    world: tuple[WorldName, ...] = (),
    group: Literal["single", "several", "extended"] | None = None,
    idle: Annotated[int, Range(1, 10_000_000, "readings of noise alone")] = 5000,
    workers: options.Workers = None,
    seed: options.Seed = 0,
    per_case: bool = False,
    output: Annotated[tuple[str, ...], options.OUTPUT] = (),
    force: options.Force = False,
    as_json: options.Json = False,
    require: tuple[str, ...] = (),
) -> int:
    """Score a solver on the cases of a folder, or on one file.

    CASES holds NPZ files as docs/how-to/judge-a-solver.md describes them: layout, elastomer,
    readings and truth, from a simulation, a rig or elsewhere; 'skinfield cases' writes some. The
    solver is told the layout, the elastomer and the noise that a case states.

    Printed are medians and 90th percentiles of the errors, the share of forces within their 90 %
    intervals, and the time per reading cold and warm, of each solver. With --noise, which is added
    to exact readings, or with --unseen in place of CASES, several noises are set beside each other;
    with --unseen also what is found in noise alone and, of presses by balls, the Cramér-Rao bound.
    In files errors are parts of the truth, with intervals of 95 % over these cases.

      skinfield cases cases && skinfield validate cases
      skinfield validate cases --solver my_package.solvers:MySolver --settings '{"snr": 20}'
      skinfield validate cases --solver tikhonov --require place_error_mm=3 -o scores.json
      skinfield validate exact --noise 0 --noise 400 --solver gaussian --solver contact
      skinfield validate --unseen 200 -o table.csv
      skinfield validate --unseen 20 --quantity stress --noise 400 --solver auto
      skinfield validate --unseen 20 --group single --world sticking --world nu-0.45

    Parameters
    ----------
    cases : str, optional
        DIR of cases, or the file of one (.npz).
    solver : tuple of str
        One of auto, contact, nonnegative, gaussian, tikhonov, pseudo-inverse, inverse; or your own
        as package.module:Class, from what is installed or lies in the current folder; or paper, its
        method: half-space, interpolated taxels, 20 x 20 nodes. Again for more. Default auto; with
        --unseen paper, gaussian and auto.
    settings : str
        Settings of the solver, as a JSON object.
    mechanics : str
        Model of the elastomer that is assumed; 'case' takes what each case says.
    grid : int
        Nodes on a side of the grid.
    gate_mm : float, mm
        Farther apart, contacts are not the same, mm.
    noise : tuple of float
        Of a reading, in the quantity's unit, added to exact readings; 0 adds none. Again for more.
        Default what the cases hold.
    unseen : int, optional
        So many random presses, made here, instead of CASES.
    quantity : tuple of str
        What taxels read, with --unseen. Again for more. Default both.
    world : tuple of str
        What skin and touch truly are, with --unseen, while solvers are told that they are as
        stated: a tangential force of half the normal one that sticks or slips, friction of 0.5
        below bodies that press straight down, another Poisson's ratio, an inextensible cover, creep
        of 15 % so long after a load came or went, and the same where that is stated and readings
        from rest on go before. Again for more.
    group : str, optional
        Of the random presses, with --unseen: balls and cones, two or three bodies, or flats, bars
        and rings. Default each in its turn.
    idle : int
        Readings of noise alone, with --unseen.
    per_case : bool
        A line per case, too.
    output : tuple of str
        A row per case (.csv), or summary and a row per reading (.json); again for both.
    require : tuple of str
        MEASURE=MOST: exit with 1 where the median, or the share 'missed', is higher; again for
        more.
    """
    values = dict(locals())
    limits_from_texts(require)
    for name in output:
        report.check_output("--output", name, force, ".csv", ".json")
    if (cases is None) == (unseen is None):
        raise InputError(
            "expected either CASES, a folder or file, or --unseen with a number of presses"
        )
    _check_together(values)
    findings, where = _of_unseen(values) if unseen is not None else _of_cases(values)
    return int(_report(findings, where, values))


def _check_together(values: dict[str, Any]) -> None:
    """Refuse what would have no effect."""
    unseen, noisy = values["unseen"] is not None, bool(values["noise"])
    named = (
        bool(values["solver"]) or not unseen,
        "--solver: with --unseen alone, solvers come as they are",
    )
    needs = {
        **dict.fromkeys(("settings", "mechanics", "grid"), named),
        **dict.fromkeys(
            ("quantity", "layout", "world", "group", "idle", "workers"), (unseen, "--unseen")
        ),
        "seed": (unseen or noisy, "--unseen or --noise"),
        "per_case": (not unseen, "CASES: -o FILE.csv has every press"),
    }
    for name, flag in options.flags_set(validate, values):
        fits, owner = needs.get(name, (True, ""))
        if not fits:
            raise InputError(f"{flag} has no effect here: it belongs to {owner}")


def _of_unseen(values: dict[str, Any]) -> tuple[Any, str]:
    """Press at random, and score every solver at every noise, beside the bound."""
    from skinfield.lab.accuracy import NOISES, AccuracyPlan, computed
    from skinfield.lab.validation import NoiseLevel, known_entrants

    quantities = values["quantity"] or tuple(NOISES)
    if values["noise"] and len(quantities) > 1:
        raise InputError("--noise is in a quantity's unit, expected one --quantity beside it")
    levels = [(each, noise) for each in quantities for noise in values["noise"] or NOISES[each]]
    chosen = [entrant_from_options(name, values) for name in values["solver"]]
    gate = values["gate_mm"] * 1e-3
    plan = AccuracyPlan(
        entrants=tuple(chosen or (replace(each, gate=gate) for each in known_entrants())),
        levels=tuple(NoiseLevel(*each) for each in dict.fromkeys(levels)),
        layout=values["layout"],
        presses=values["unseen"],
        idle=values["idle"],
        seed=values["seed"],
        worlds=tuple(dict.fromkeys(values["world"])),
        group=values["group"],
    )
    number = options.processes(values["workers"])
    patch = plan.patch.name  # an unknown one is said before anything is computed
    with report.progress("unseen presses") as step:
        return computed(plan, number, step), patch


def _of_cases(values: dict[str, Any]) -> tuple[Any, str]:
    """Score every solver on the readings that cases hold, or at noises added to exact ones."""
    from skinfield.lab.accuracy import Findings
    from skinfield.lab.case_files import case_paths, load_case
    from skinfield.lab.validation import NoiseLevel, noise_seed, rows_of_case

    tried = [
        entrant_from_options(name, values) for name in values["solver"] or (options.USUAL_SOLVER,)
    ]
    paths: list[Path] = case_paths(values["cases"])
    rows: Rows = []
    with report.progress("scoring", len(paths)) as step:
        for index, path in enumerate(paths):
            case, seed = load_case(path), noise_seed(values["seed"], index)
            levels = [NoiseLevel(case.quantity, noise) for noise in values["noise"]]
            for method in tried:
                with named(path, method.name):
                    scored = list(rows_of_case(case, levels, [method], seed))
                rows += [{"file": path.name} | row for row in scored]
            step()
    return Findings(rows), values["cases"]


def _report(findings: Any, where: str, values: dict[str, Any]) -> bool:
    """Print a table for each quantity, and write; whether a limit is exceeded."""
    from skinfield.files import write_summary
    from skinfield.lab.accuracy import accuracy_rows
    from skinfield.lab.score import rows_by_case, write_csv

    summary = accuracy_rows(findings, seed=values["seed"])
    count = plural(len({row["case"] for row in findings.rows}), "case")
    if values["as_json"]:
        report.print_json(summary)
    else:  # wider than other tables
        out = Console(width=max(report.console().width, WIDE))
        if values["per_case"]:
            out.print(report.table_of("Errors of each case", rows_by_case(findings.rows), EACH))
        for quantity in dict.fromkeys(row["quantity"] for row in summary):
            mine = [row for row in summary if row["quantity"] == quantity]
            out.print(table_of_summary(mine, f"{quantity}: {count} on {where}"))
    used = {key: values[key] for key in ("solver", "settings", "mechanics", "grid", "gate_mm")}
    for name in values["output"]:
        if name.lower().endswith(".csv"):
            write_csv(rows_by_case(findings.rows), name)
        else:
            about = {"options": {"on": where} | used, "summary": summary}
            write_summary(name, about | {"rows": findings.rows})
        if not values["as_json"]:
            report.say(f"wrote {name}")
    limits = limits_from_texts(values["require"])
    judged = [row for row in summary if "missed" in row]  # not the bound
    exceeded = [exceeds(limits, row) for row in judged]  # each is named
    return any(exceeded)


# ---- solvers


def entrant_from_options(name: str, values: dict[str, Any]) -> Any:
    """Solver of a name with the mechanics and the grid of the options; the paper's has its own."""
    from skinfield.lab.validation import PAPER, Entrant, known_entrants

    if values["settings"] != "{}" and (len(values["solver"]) > 1 or name == PAPER):
        raise InputError(
            f"--settings is {values['settings']!r}, expected it beside one --solver that takes "
            "them: the paper's method has none"
        )
    gate = values["gate_mm"] * 1e-3
    if name == PAPER:
        paper = next(entrant for entrant in known_entrants() if entrant.name == PAPER)
        return replace(paper, gate=gate)
    mechanics = values["mechanics"]
    return Entrant(
        name=name,
        solver=solver_from_text(name, values["settings"]),
        mechanics=None if mechanics == "case" else options.mechanics_of(mechanics),
        nodes=values["grid"],
        gate=gate,
    )


@contextmanager
def named(path: Path, solver: str) -> Iterator[None]:
    """Errors name the case; those of a solver from elsewhere also where they come from."""
    try:
        yield
    except InputError as error:
        raise FileError(f"{path}: {error}") from error
    except MemoryError as error:
        raise FileError(
            f"{path} does not fit into memory, expected positions in metres on a patch of some "
            f"decimetres, or a coarser --grid: {error}"
        ) from error
    except Exception as error:
        if ":" not in solver:
            raise
        last = traceback.extract_tb(error.__traceback__)[-1]
        raise FileError(
            f"{path}: --solver {solver} fails with {type(error).__name__}: {error} "
            f"({last.filename}, line {last.lineno})"
        ) from error


def solver_from_text(text: str, settings: str = "{}") -> Any:
    """Solver by its name, or imported, such as "package.module:Class", and made with settings.

    Raises InputError if there is no such solver, it does not take these settings, a JSON object, or
    it has no `prepare`.
    """
    try:
        keywords = json.loads(settings)
    except ValueError:
        keywords = None
    if not isinstance(keywords, dict):
        raise InputError(f"--settings is {settings!r}, expected a JSON object such as {{}}")
    if ":" in text:
        make = _imported(text)
    elif text in options.SOLVERS:
        make = getattr(sf, options.SOLVERS[text])
    else:
        raise InputError(
            f"--solver is {text!r}, expected one of {', '.join(options.SOLVERS)}, or your own as "
            "package.module:Class"
        )
    ready = (_is_solver(make) and not keywords) or not callable(make)
    try:
        solver = make if ready else make(**keywords)
    except TypeError as error:
        raise InputError(f"--settings is {settings}, but {text} says: {error}") from error
    if not _is_solver(solver):
        raise InputError(
            f"--solver is {text!r}, which has no prepare(model), expected a solver: "
            "see CONTRIBUTING.md"
        )
    return solver


def _is_solver(value: Any) -> bool:
    """Whether it is an object, not a class of objects, that prepares."""
    return not isinstance(value, type) and callable(getattr(value, "prepare", None))


def _imported(text: str) -> Any:
    """What "package.module:name" names; modules of the current folder count."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)  # processes that are started later import from it, too
    try:
        return pkgutil.resolve_name(text)
    except Exception as error:  # whatever runs while a foreign module is imported
        raise InputError(
            f"--solver is {text!r}, which cannot be imported: {type(error).__name__}: {error}"
        ) from error


# ---- tables and limits


def limits_from_texts(texts: Sequence[str]) -> dict[str, float]:
    """Highest allowed values by measure, from texts such as "missed=0.1"."""
    from skinfield.lab.score import MEASURES, RATES

    known = (*MEASURES[:-2], "force_bias", *RATES)  # times are not for limits

    limits = {}
    for text in texts:
        name, _, most = text.partition("=")
        with suppress(ValueError):
            limits[name] = float(most)
        if name not in known or name not in limits:
            raise InputError(
                f"--require is {text!r}, expected MEASURE=NUMBER with one of {', '.join(known)}"
            )
    return limits


def exceeds(limits: dict[str, float], columns: dict[str, Any]) -> bool:
    """Whether a limit is exceeded, or there is no number to compare, which stderr then says."""
    failed = False
    for name, most in limits.items():
        value = float(columns.get(f"{name}_median", columns.get(name, math.nan)))
        if not value <= most:
            failed = True
            sys.stderr.write(f"{name} is {value:.4g}, required at most {most:g}\n")
    return failed


def table_of_summary(rows: Sequence[dict[str, Any]], title: str) -> Any:
    """Medians and 90th percentiles, noise by noise and solver by solver."""
    known = set().union(*rows)
    shown = [each for each in COLUMNS if {each.key, f"{each.key}_median"} & known]
    title += "; median/90th percentile"
    worlds = ("world",) if "world" in known else ()
    words = (*worlds, "noise", "solver")
    made = report.table(title, words, [each.head for each in shown], box=SIMPLE_HEAD)
    places = [(row.get("world"), row["noise"]) for row in rows]
    for index, row in enumerate(rows):
        new = index == 0 or places[index] != places[index - 1]
        last = index + 1 == len(rows) or places[index + 1] != places[index]
        noise = "as it is" if row["noise"] is None else f"{row['noise']:g}"
        heads = [*(row[each] for each in worlds), noise]
        cells = [*(head if new else "" for head in heads), row["method"].rpartition(":")[2]]
        for key, factor, digits in ((each.key, each.factor, each.decimals or 0) for each in shown):
            ends = (f"{key}_median", f"{key}_p90") if f"{key}_median" in row else (key,)
            cells.append("/".join(_cut(row.get(end, math.nan) * factor, digits) for end in ends))
        made.add_row(*cells, end_section=last)
    return made


def _cut(value: float, digits: int) -> str:
    """A number; an exponent would hide how large it is, so what is huge is cut."""
    return report.fixed(value, digits) if not 1e4 <= abs(value) < math.inf else ">9999"


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

"""The command's entry point: one app, whose commands are loaded when they are called."""

import atexit
import gc
import inspect
import os
import re
import sys
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from typing import Any, NamedTuple

from cyclopts import App, ArgumentCollection, CycloptsError, Group, Parameter, Token
from cyclopts.exceptions import UnknownCommandError
from cyclopts.help import DefaultFormatter, PanelSpec
from rich.box import Box

from skinfield.cli.options import LIVE, check_values, flag_of, settings_in
from skinfield.errors import FileError, SkinfieldError
from skinfield.processes import ONE_THREAD
from skinfield.settings import SettingError, nearest

FAILED, INTERRUPTED = 2, 130  # exit codes: an error of the user's input, Ctrl-C
USUAL = frozenset({"output", "force", "as_json", "seed"})  # flags of a demo of the usual presses
ANSWER = "skinfield.solve.atoms.reading_kernel.answer_reading"  # what takes longest to compile
PLAIN = Box("    \n" * 8)  # no lines around help
WIDEST = 100  # columns of help


class Lazy(NamedTuple):
    """A command that is imported when it is called: `skinfield --help` needs none of them.

    `group` is the heading that it stands under; empty where it stands under none.
    """

    where: str
    help: str
    group: str = ""


LAB = {
    "experiments": Lazy("experiments:experiments", "Make the paper's figures anew, with a report."),
    "cases": Lazy("validate:cases", "Write simulated cases to judge solvers by."),
    "validate": Lazy("validate:validate", "Score a solver on cases whose truth is known."),
    "press": Lazy("press:press", "Press bodies of any shape on simulated skin."),
    "rig": Lazy("rig:rig", "Press a simulated skin on a virtual rig."),
}
COMMANDS = {
    "demo": Lazy("demo:demo", "Press a simulated patch, reconstruct it, draw it.", "Start"),
    "new": Lazy("new:new", "Make the file of your own skin.", "Start"),
    "run": Lazy("run:run", "Bring a robot's skin alive.", "Start"),
    "view": Lazy("replay:view", "Show a recording, or skins elsewhere, in the browser.", "Start"),
    "record": Lazy("record:record", "Record a running skin into one MCAP file.", "Recordings"),
    "replay": Lazy("replay:replay", "Show a recording as it was.", "Recordings"),
    "export": Lazy("export:export", "Turn a recording into Parquet, CSV, a bag ...", "Recordings"),
    "info": Lazy("record:info", "What a recording of a live skin holds."),
    "recover": Lazy("record:recover", "Make a whole recording of a damaged one."),
    "reconstruct": Lazy(
        "reconstruct:reconstruct", "Turn a recording into contacts and fields.", "Offline"
    ),
    "calibrate": Lazy("calibrate:calibrate", "Fit the skin to known loads.", "Offline"),
    "layout": Lazy("layout:layout", "Show, check and convert taxel layouts.", "Skin"),
    "design": Lazy("design:design", "Judge a layout before it is made.", "Skin"),
    "bench": Lazy("bench:bench", "Time the solvers here: cost, error against time.", "Machine"),
    "doctor": Lazy("doctor:doctor", "What this machine has and lacks, and the remedy."),
    "status": Lazy("status:status", "What runs, and how well it keeps its time."),
    "tune": Lazy("status:tune", "Change how a running skin answers."),
    "tare": Lazy("status:tare", "Take the baseline of an untouched skin anew."),
    "warmup": Lazy("run:warmup", "Compile once for this machine what a run needs."),
    "emulate": Lazy("emulate:emulate", "Be a skin: boards that do not exist, on a real bus."),
    **LAB,
}
LAB_HELP = """Simulated skins and their truth: press, rig, cases, validate, experiments.

  skinfield lab press --indenter "sphere radius=6" --skin hexagon72 --plot truth.png"""
HELP = """Turn the readings of robot skin into force, deformation and contacts.

Start with

  skinfield demo                  a press without any hardware, as a picture
  skinfield run                   a virtual skin alive, in the browser
  skinfield new                   your own skin, from a CSV of its taxels and a log
  skinfield run my_robot.toml     your own robot
  skinfield doctor                what this machine lacks, and the remedy
  skinfield COMMAND --help        what a command takes, with examples
  skinfield lab COMMAND --help    the same of press, rig, cases, validate, experiments

Of a running skin also: status, tune, tare, emulate, warmup; of recordings: info, recover."""


def shown_default(value: Any) -> str | None:
    """Default value in help; nothing where there is none."""
    return None if value is None or isinstance(value, bool) or value in ((), "") else str(value)


def reflowed(text: str) -> str:
    """Help of a docstring: its paragraphs in one line each, what is indented as it is."""
    text, paragraphs = re.split(r"\nParameters\n-+\n", inspect.cleandoc(text))[0], []
    for paragraph in text.split("\n\n"):
        lines = paragraph.splitlines()
        plain = not any(line.startswith(" ") for line in lines)
        paragraphs.append(" ".join(lines) if plain else "\n".join(lines))
    return "\n\n".join(paragraphs).strip("\n")


def new_app(name: str, text: str, **more: Any) -> App:
    """An app, or a command with commands of its own, as all of this program are."""
    return App(
        name=name,
        help=text,
        help_format="plaintext",
        help_formatter=DefaultFormatter(panel_spec=PanelSpec(box=PLAIN, padding=(0, 1))),
        help_flags=("--help", "-h"),
        name_transform=flag_of,
        default_parameter=Parameter(
            negative_iterable=(),
            negative_none=(),
            show_default=shown_default,
            name_transform=flag_of,
        ),
        **more,
    )


def reflow_help(app: App) -> None:
    """Let help of a command, and of its own commands, have lines as wide as the terminal."""
    app.help = reflowed(app.help)
    for each in app.subapps:
        if not set(each.name) & {"--help", "--version"}:
            reflow_help(each)


def add_commands(app: App, commands: dict[str, Lazy], called: str) -> None:
    """Add commands to an app: with its own whole help the one that is called."""
    groups = {
        name: Group(name or "Commands", sort_key=place)
        for place, name in enumerate(dict.fromkeys(lazy.group for lazy in commands.values()))
    }
    for place, (name, lazy) in enumerate(commands.items()):
        app.command(
            f"skinfield.cli.{lazy.where}",
            name=name,
            group=groups[lazy.group] if lazy.group else None,
            show=bool(lazy.group) or commands is LAB,
            sort_key=place,
            help=None if name == called else lazy.help,
        )


def app_for(words: Sequence[str]) -> App:
    """The program, as it is called."""
    called = [word for word in words if not word.startswith("-")] + ["", ""]
    app = new_app("skinfield", HELP, version=lambda: version("skinfield"), config=settings_of_file)
    add_commands(app, COMMANDS, called[0])
    lab = new_app("lab", LAB_HELP, group=Group("Research", sort_key=98))
    add_commands(lab, LAB, called[1])
    app.command(lab)
    if called[0] in COMMANDS:
        reflow_help(app[called[0]])
    elif called[0] == "lab" and called[1] in LAB:
        reflow_help(lab[called[1]])
    app["--help"].group = app["--version"].group = Group("Options", sort_key=99)
    app.register_install_completion_command(name="--install-completion", show=False)
    return app


def settings_of_file(app: App, commands: tuple[str, ...], arguments: ArgumentCollection) -> None:
    """Take from FILE of `run FILE` what no flag says."""
    if commands != ("run",):
        return
    from skinfield.cli.settings import changed, load_settings

    file = next(each for each in arguments if each.field_info.name == "file")
    for path in (token.value for token in file.tokens):
        found = settings_in(path) if path.lower().endswith(LIVE) else load_settings(path)
        if found is None:
            raise FileError(f"{path} holds no settings, expected a recording of `skinfield run`")
        values = {name: value for part in changed(found).values() for name, value in part.items()}
        for each in arguments:
            name = each.field_info.name
            if name in values and each.keys and not each.tokens:
                value = values[name]
                for one in value if isinstance(value, list) else (value,):
                    each.append(Token(source=path, implicit_value=one))


def main(words: Sequence[str] | None = None) -> None:
    """Run the command of these words, by default those of the command line, and exit.

    The exit code is 2 after an error of the user's input, which is one paragraph on stderr. It runs
    on one BLAS thread: products of a few megabytes lose more by waking others than they gain.
    """
    from threadpoolctl import threadpool_limits

    alone, words = words is None, sys.argv[1:] if words is None else words
    if alone:  # for what is loaded later, such as SciPy's own BLAS: no limit is set there
        os.environ.update({name: os.environ.get(name, one) for name, one in ONE_THREAD.items()})
        atexit.register(gc.freeze)  # at the end no garbage is looked for: that takes half a second
    app = app_for(words)
    try:
        with threadpool_limits(limits=1):
            command, bound, _ = app.parse_args(
                words, exit_on_error=False, print_error=False, console=_console()
            )
            if command.__module__.startswith("skinfield."):  # not --help
                check_values(command, bound.arguments)
            if alone and words[0] == "demo":
                interpret_first(bound.arguments)
            code = command(*bound.args, **bound.kwargs)
    except KeyboardInterrupt:
        code = INTERRUPTED
    except (CycloptsError, SkinfieldError) as error:
        text = _usage_error(error) if isinstance(error, CycloptsError) else str(error)
        if isinstance(error, SettingError):  # with the flag in place of the field's name
            text = f"--{flag_of(error.name)} {error.text}"
        print(f"Error: {text}", file=sys.stderr)  # noqa: T201 - the program's own words
        code = FAILED
    sys.exit(code if isinstance(code, int) else 0)


def interpret_first(given: Iterable[str]) -> None:
    """Interpret a machine's first demo, of the usual presses: compiling takes far longer.

    It is for a process that does nothing else. Garbage, which would take a tenth of its time to
    look for, is left to the system.
    """
    from skinfield.compile_progress import is_compiled
    from skinfield.compiled import interpret

    if USUAL.issuperset(given) and not is_compiled(ANSWER):
        interpret()
        gc.disable()


def _console() -> Any:
    """Where help goes: not wider than can be read."""
    from rich.console import Console

    console = Console()
    console.width = min(console.width, WIDEST) if console.is_terminal else WIDEST
    return console


def _usage_error(error: CycloptsError) -> str:
    """What is wrong with a command line, and where its help is."""
    chain = error.command_chain or ()
    called = " ".join(["skinfield", *chain])
    if isinstance(error, UnknownCommandError) and error.unused_tokens:
        word, known = error.unused_tokens[0], [name for name in error.app or () if name[0] != "-"]
        text = f"{word!r} is no command of {called}{nearest(word, known)}"
    else:
        text = str(error)
    return f"{text}\nTry '{called} --help'."

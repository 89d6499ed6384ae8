"""Options of `skinfield run`, and the settings that they make."""

from collections.abc import Callable
from typing import Any, TypeVar

import click

from skinfield.cli.options import MECHANICS, QUANTITIES, SOLVERS, layer_options
from skinfield.errors import InputError, check_range

F = TypeVar("F", bound=Callable[..., Any])
LIVE_SOLVERS = [name for name in SOLVERS if name != "contact"]
RUNGS = (10, 20, 40, 80)
USUAL_SHIFT = 2  # bits that an iCub's boards drop


def source_options(function: F) -> F:
    """Where readings come from."""
    for option in (
        click.option(
            "--set",
            "extra",
            multiple=True,
            metavar="KEY=VALUE",
            help="A setting of the source, such as config=robot.xml; again for more.",
        ),
        click.option(
            "--channel",
            multiple=True,
            help="Of the bus: can0, an address and port, a device; again for several buses.",
        ),
        click.option("--bus", help="How it is connected: socketcan, udp_multicast, serial ..."),
        click.option(
            "--hardware",
            help="Whose boards: icub, yarp, cyskin, packet. Without it a virtual skin is started.",
        ),
        click.option(
            "--skin", "skin_text", default="hexagon72", show_default=True, metavar="LAYOUT",
            help="Layout file, or a generator by name.",
        ),
    ):  # fmt: skip
        function = option(function)
    return function


def answer_options(function: F) -> F:
    """How readings are answered."""
    for option in (
        click.option(
            "--tare-s", default=1.0, show_default=True, help="Of an untouched skin, at the start."
        ),
        click.option("--gain", type=float, help="Counts per unit of ΔC/C₀. Default a guess."),
        click.option("--no-load", type=int, help="What an iCub byte rests at. [default: 240]"),
        click.option(
            "--quantity", type=click.Choice(list(QUANTITIES)), default="capacitance",
            show_default=True, help="What a taxel reads.",
        ),
        click.option(
            "--mechanics", type=click.Choice(list(MECHANICS)), default="layer", show_default=True,
            help="Model of the elastomer.",
        ),
        click.option(
            "--solver", type=click.Choice(LIVE_SOLVERS), default="nonnegative", show_default=True,
            help="How readings become pressure.",
        ),
        click.option(
            "--grid", type=int, default=40, show_default=True,
            help="Nodes on a side of the finest grid.",
        ),
        click.option(
            "--threshold-n", default=0.0, show_default=True,
            help="Contacts of a smaller force are not told, N.",
        ),
        click.option(
            "--smoothing-ms", default=0.0, show_default=True,
            help="Time constant of a low-pass of what each taxel reads, ms; 0: none.",
        ),
        click.option("--budget-us", type=float, help="For the reconstruction in each cycle, µs."),
        click.option(
            "--deadline-ms", type=float, help="When an estimate is late, ms. [default: one period]"
        ),
        click.option("--events", is_flag=True, help="A cycle when readings arrive, at no rate."),
        click.option("--rate", default=1000.0, show_default=True, help="Cycles per second."),
    ):  # fmt: skip
        function = option(function)
    return layer_options(function)


def system_options(function: F) -> F:
    """What is asked of the system."""
    for option in (
        click.option("--cpu", type=int, help="To pin the engine to. Default an isolated one."),
        click.option(
            "--priority", default=80, show_default=True,
            help="Of SCHED_FIFO, where it is granted; 0: not asked for.",
        ),
        click.option(
            "--name", default="skin", show_default=True, help="By which other programs find it."
        ),
    ):  # fmt: skip
        function = option(function)
    return function


def rungs_to(grid: int) -> tuple[int, ...]:
    """Resolutions from coarse to this one."""
    if grid < 4:
        raise InputError(f"--grid is {grid}, expected 4 nodes on a side or more")
    return (*(nodes for nodes in RUNGS if nodes < grid), grid)


def extra_settings(texts: tuple[str, ...]) -> dict[str, str]:
    """Settings of a source, from KEY=VALUE."""
    found: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key:
            raise InputError(f"--set is {text!r}, expected KEY=VALUE, such as config=robot.xml")
        found[key] = value
    return found


class NotYet:
    """Stands for a source that is not there yet, while settings are checked."""

    def open(self) -> Any:
        """Nobody opens it."""
        raise InputError("the source is not known yet")


def settings_from(given: dict[str, Any], skin: Any, source: Any) -> Any:
    """`LiveSettings` of the options; the source is one of the live sources."""
    from skinfield.cli.options import layer_from_options
    from skinfield.live.settings import LiveSettings
    from skinfield.live.tuning import HEAVIEST, SLOWEST
    from skinfield.realtime import RealTime

    micro, milli = given["budget_us"], given["deadline_ms"]
    check_range("--threshold-n", given["threshold_n"], 0.0, HEAVIEST, "N, of contacts")
    check_range("--smoothing-ms", given["smoothing_ms"], 0.0, SLOWEST * 1e3, "ms; 0: none")
    return LiveSettings(
        skin=skin,
        sources=(source,),
        name=given["name"],
        layer=layer_from_options(given["thickness_mm"], given["modulus_kpa"], given["poisson"]),
        mechanics=MECHANICS[given["mechanics"]](),
        quantity=QUANTITIES[given["quantity"]](),
        solver=live_solver(given["solver"]),
        rungs=rungs_to(given["grid"]),
        board=board_of(given["hardware"], given["no_load"], shift_of(given)),
        gain=given["gain"],
        rate=None if given["events"] else given["rate"],
        budget=None if micro is None else micro * 1e-6,
        deadline=None if milli is None else milli * 1e-3,
        threshold=given["threshold_n"],
        smoothing=given["smoothing_ms"] * 1e-3,
        tare_seconds=given["tare_s"],
        real_time=RealTime(priority=given["priority"], cpu=given["cpu"]),
    )


def live_solver(name: str) -> Any:
    """As elsewhere, but for the gap to which a search goes."""
    from skinfield.inverse import NonNegative
    from skinfield.live.settings import LIVE_TOLERANCE

    return NonNegative(tolerance=LIVE_TOLERANCE) if name == "nonnegative" else SOLVERS[name]()


def shift_of(given: dict[str, Any]) -> int:
    """Bits that an iCub's boards drop, as they are told with ``--set shift=``."""
    text = extra_settings(given["extra"]).get("shift", str(USUAL_SHIFT))
    if not text.isdecimal():
        raise InputError(f"--set shift is {text!r}, expected a whole number, 2 on most robots")
    return int(text)


def board_of(hardware: str | None, no_load: int | None, shift: int = USUAL_SHIFT) -> Any:
    """What a count of this hardware means; None to go by the range of the counts."""
    from skinfield.conditioning import CySkinCount, ICubByte

    if hardware in (None, "icub", "yarp"):
        known = {} if no_load is None else {"no_load": no_load}
        return ICubByte(shift=shift, **known)
    if no_load is not None:
        raise InputError(f"--no-load is {no_load}, expected it with iCub boards only")
    return CySkinCount() if hardware in ("cyskin", "shm") else None

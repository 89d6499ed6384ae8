"""`skinfield run`: a robot's skin, alive; `skinfield warmup`: its code compiled before."""

import os
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import IO, Annotated, Any, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.live import Live as Screen

from skinfield.bridges.settings import BridgeSettings
from skinfield.cli import options, report
from skinfield.cli.profiles import SkinProfile
from skinfield.cli.settings import (
    LoopSettings,
    ModelSettings,
    RecordSettings,
    Settings,
    SkinSettings,
    SolverName,
    SourceSettings,
    changed,
    taxels_of,
    toml_from_settings,
)
from skinfield.errors import InputError, SkinfieldError
from skinfield.estimate.contact_table import scale_of
from skinfield.page.settings import PageSettings
from skinfield.processes import Child, start_python

REFRESH = 0.25  # s
DIGITS = 4  # to which numbers of contacts are rounded: what they are good for
SETTLE = 3.0  # s that the engine answers a press, to warm up
SILENT = 5.0  # s without a message until that is reported
RECENT = 1.0  # s that the table calls the last
STARTS = 600.0  # s without any progress of a start: code may have to be compiled first
LOOK = 0.05  # s between looks whether contacts are ready
SAYS = 5.0  # s from line to line about a start, where there is no table
RUNGS = (10, 20, 40, 80)
USUAL_SHIFT = 2  # bits that an iCub's boards drop
LIVE_FINEST = 40  # nodes on a side of the finest grid, unless given
ON_CAN = (None, "icub", "cyskin")  # hardware whose bus is one of CAN
# The virtual skin has a tenth of the noise of a robot's boards, 0.002 in ΔC/C₀, and its boards
# drop one bit, not two: the noise then outweighs the rounding, and averages go on getting better.
VIRTUAL_NOISE, VIRTUAL_SHIFT = 0.1, 1


def run(
    file: str | None = None,
    /,
    *,
    duration: options.Duration = None,
    headless: bool = False,
    as_json: options.Json = False,
    save: str | None = None,
    force: options.Force = False,
    skin: Annotated[SkinSettings, options.part("Skin")] = SkinSettings(),
    source: Annotated[SourceSettings, options.part("Source of readings")] = SourceSettings(),
    model: Annotated[ModelSettings, options.part("Model")] = ModelSettings(),
    loop: Annotated[LoopSettings, options.part("Loop")] = LoopSettings(),
    page: Annotated[PageSettings, options.part("Page")] = PageSettings(),
    bridges: Annotated[BridgeSettings, options.part("Bridges")] = BridgeSettings(),
    record: Annotated[RecordSettings, options.part("Recording")] = RecordSettings(),
) -> None:
    """Run the live engine: readings in, contacts out, in newtons, cycle after cycle on time.

    The page of the skin opens in the browser: it shows what touches, and lets you press.

    With nothing attached a virtual skin is started, which speaks the bytes of iCub's boards. The
    engine works in a process of its own, at real-time priority where the system grants it; what
    is not granted is told by `skinfield status`, with the remedy. It starts with a baseline: leave
    the skin untouched for the first second or two.

    FILE (.toml) holds any of the settings below by their names, with _ for -, in tables; flags come
    before what it says. --save writes one. A recording (.mcap) holds those that it was made with.

      skinfield run
      skinfield run --skin cylinder --scene slide
      skinfield run --record touch.mcap --duration 60
      skinfield run --hardware icub --bus socketcan --channel can0 --skin right_foot.txt
      skinfield run --hardware packet --bus udp --channel 0.0.0.0:9870 --skin my_skin.toml
      skinfield run --hardware cyskin --skin my_skin.json --save my_robot.toml
      skinfield run --robot robot.urdf --skin l_hand=left.txt --skin r_hand=right.txt
      skinfield run my_robot.toml --duration 10 --headless --json

    Other programs get the estimates with `skinfield.connect()`, see docs/tutorials/live-skin.md;
    other machines with --zenoh, --ros2 and --yarp. Ctrl-C ends all.

    Parameters
    ----------
    file : str, optional
        Settings (.toml), or a recording of such a run (.mcap).
    headless : bool
        No table and no browser: for services and scripts.
    save : str, optional
        Write the settings to this file (.toml), and run nothing.
    """
    from skinfield.files.pending import write_bytes

    wanted = Settings(
        skin=skin, source=source, model=model, loop=loop, page=page, bridges=bridges, record=record
    )
    if save is not None:
        report.check_output("--save", save, force, ".toml")
        write_bytes(save, toml_from_settings(wanted).encode())
        report.note(f"wrote {save}")
        return
    console = Console(stderr=True)
    check_settings(wanted, force)
    with report.signals_end() as came, ExitStack() as parts:
        try:
            browser = page.browser and not headless

            def opened(address: str) -> None:
                report.show_address(address, console, browser=browser, as_json=as_json)

            running = start_all(wanted, parts, console, opened)
            if came:
                raise KeyboardInterrupt
            screen = None
            if not headless:
                screen = Screen(console=console, auto_refresh=False, vertical_overflow="crop")
                screen.start()
            summary = watch(running, duration, screen, console)
        finally:
            report.end_undisturbed()
    if as_json:
        report.print_json(summary)


def check_settings(wanted: Settings, force: bool = False) -> None:
    """Refuse, before anything starts, what can be seen without a skin."""
    from skinfield.bridges.launch import bridge_settings
    from skinfield.emulator.scenes import SCENES
    from skinfield.loop import check_free
    from skinfield.wire.can.adapters import check_interface

    report.check_output("--record", wanted.record.into, force, ".mcap")
    check_free(wanted.loop.name)
    check_port(wanted.page.port, wanted.page.host)
    bridge_settings(wanted.bridges)
    bus = wanted.source.bus
    if bus and wanted.source.hardware in ON_CAN:
        options.parsed("--bus", bus, check_interface)
    source = wanted.source
    if source.hardware is not None and source.habits != SourceSettings.habits:
        raise InputError(
            f"--habits is {source.habits} beside --hardware {source.hardware}, expected none: they "
            "are those of the virtual skin"
        )
    scene = wanted.source.scene
    if wanted.source.hardware is None and scene not in SCENES and not Path(scene).is_file():
        raise InputError(
            f"--scene is {scene!r}, expected one of {', '.join(SCENES)}, or the path of a file"
        )


def check_port(port: int | None, host: str) -> None:
    """Refuse a port or an address that the page cannot be served on; None is any port."""
    place = host.strip("[]") or None, port or 0  # an empty host is all of the machine's
    try:
        known = socket.getaddrinfo(*place, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        socket.create_server(known[0][4], family=known[0][0]).close()
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(
            f"port {port or 'of any number'} of {host} cannot be served: {why}; expected a --port "
            "that is free, and a --host of this machine, such as 127.0.0.1, or 0.0.0.0 for all"
        ) from error


def live_settings(
    wanted: Settings, profile: SkinProfile, skin: Any, source: Any, assumed: tuple[str, ...] = ()
) -> Any:
    """`LiveSettings` of the settings; the source is one of the live sources.

    `assumed` is what of the scale of forces nothing known gives, see `options.assumed_of`.
    """
    from skinfield.loop.realtime import RealTime
    from skinfield.loop.settings import LiveSettings

    model, loop = options.filled(wanted.model, profile), wanted.loop
    late, deadline = loop.late_after_ms, loop.deadline_us
    grid = model.grid or max(options.nodes_for(patch, LIVE_FINEST) for patch in skin)
    taxels, sent = sum(map(len, skin)), getattr(source, "unit", "count")
    calibration = options.calibration_for(wanted.skin.calibration, skin)
    if sent == "count" and any(its.unit != "count" for its in calibration.values()):
        raise InputError(
            f"--calibration is {wanted.skin.calibration!r}, made of readings in ΔC/C₀, and the "
            "source sends counts: expected one made of counts"
        )
    return LiveSettings(
        skin=skin,
        sources=(source,),
        name=loop.name,
        layer=options.layer_of(wanted.skin, profile),
        mechanics=options.mechanics_of(model.mechanics or profile.mechanics),
        quantity=options.quantity_of(model.quantity or "capacitance"),
        solver=options.solver_of(model.solver or "auto"),
        rungs=(*(nodes for nodes in RUNGS if nodes < grid), grid),
        board=board_of(wanted.source, wanted.skin.no_load, profile),
        gain=options.filled(wanted.skin, profile).gain,
        calibration=calibration,
        keep=taxels_of("--keep", wanted.skin.keep, taxels),
        without=taxels_of("--without", wanted.skin.without, taxels),
        relative=options.is_relative(assumed, sent),
        rate=None if loop.events else loop.rate_hz,
        budget=None if deadline is None else deadline * 1e-6,
        deadline=None if late is None else late * 1e-3,
        threshold=loop.threshold_n,
        smoothing=loop.smoothing_ms * 1e-3,
        tare_seconds=loop.tare_s,
        real_time=RealTime(priority=loop.priority, cpu=loop.cpu),
    )


def calibrated(wanted: Settings) -> tuple[Settings, tuple[str, ...]]:
    """Settings with what a calibration by touches knows, and what of the scale of forces does not.

    A virtual skin stays as it was wanted, and without a calibration is what it is taken to be.
    """
    skin, model, touched = options.by_touch(wanted.skin.calibration, wanted.skin, wanted.model)
    assumed = options.assumed_of(wanted.skin, wanted.skin, touched)
    if wanted.source.hardware is None and touched is None:
        assumed = ()
    return replace(wanted, skin=skin, model=model), assumed


def board_of(source: SourceSettings, no_load: int | None, profile: SkinProfile) -> Any:
    """What a count of this hardware means; None to go by the range of the counts."""
    from skinfield.signal import CySkinCount, ICubByte

    if source.hardware in (None, "icub", "yarp"):
        shift = source.named_options.get("shift", str(USUAL_SHIFT))  # bits that the boards drop
        if not shift.isdecimal():
            raise InputError(f"--set shift is {shift!r}, expected a whole number, 2 on most robots")
        rest = no_load or profile.no_load or options.USUAL_NO_LOAD
        return ICubByte(shift=int(shift), no_load=rest)
    if no_load is not None:
        raise InputError(f"--no-load is {no_load}, expected it with iCub boards only")
    return CySkinCount() if source.hardware in ("cyskin", "shm") else None


def virtual_skin(wanted: Settings, profile: SkinProfile) -> Any:
    """The virtual skin that is there when no hardware is; a context."""
    from skinfield.emulator.process import start
    from skinfield.emulator.settings import NO_HABITS, VirtualSettings

    source = wanted.source
    with options.layout_text(wanted.skin) as text:
        settings = VirtualSettings(
            hardware="icub",
            skin=text,
            bus=source.bus or "udp",
            channels=source.channel,
            rate=source.virtual_rate_hz,
            layer=options.layer_of(wanted.skin, profile),
            habits=source.habits,
            noise_scale=VIRTUAL_NOISE if source.habits == NO_HABITS else None,
            scene="idle",  # until the engine has its baseline
            lead_in=0.0,
            seed=source.seed,
        )
        return start(settings)


def on_virtual_boards(source: SourceSettings, channels: Sequence[str]) -> SourceSettings:
    """Settings of a source that reads the virtual skin, with what its boards are sent."""
    period = max(round(1e3 / source.virtual_rate_hz), 1)
    texts = (f"period_ms={period}", f"shift={VIRTUAL_SHIFT}", *source.options)
    bus = source.bus or "udp"
    return replace(source, hardware="icub", bus=bus, channel=tuple(channels), options=texts)


def newest_source(name: str) -> Callable[[], Sequence[Any]]:
    """What returns the source of a skin that runs here: another once a new ring has its name."""
    from skinfield.page.source import LiveSource

    newest = [LiveSource(name)]

    def sources() -> Sequence[Any]:
        if newest[0].replaced:
            with suppress(SkinfieldError):  # it is being made anew
                newest[0] = LiveSource(name)  # the old one goes with its last reader
        return newest

    return sources


@contextmanager
def served_page(wanted: Settings, supervisor: Any, virtual: Any) -> Iterator[Any]:
    """Serve the page of the skin that runs here, with its `controller`."""
    from skinfield.page.live_controller import LiveController
    from skinfield.page.recordings import Recordings
    from skinfield.page.replay import RecordingSource
    from skinfield.page.server import serve_page
    from skinfield.record.launch import ReadyRecorders

    name = wanted.loop.name
    sources, recorders = newest_source(name), ReadyRecorders(name)

    controller = LiveController(
        lambda: sources()[0],
        virtual=virtual,
        recordings=Recordings(
            name, recorders, RecordingSource, Path(), lambda text: controller.say("error", text)
        ),
        solvers=get_args(SolverName),
        solver=wanted.model.solver or "auto",
        choose=lambda solver: supervisor.reconfigure(solver=options.solver_of(solver)),
        tare_seconds=wanted.loop.tare_s,
    )
    try:
        with serve_page(wanted.page, sources, controller) as page:
            yield page
    finally:
        controller.close()


@contextmanager
def loading_engine() -> Iterator[tuple[Child, IO[bytes]]]:
    """An engine's process that loads its code while this one loads its own; with its errors."""
    with tempfile.TemporaryFile() as errors:
        words = ("skinfield.loop.engine_process", str(os.getpid()))
        child = start_python(*words, stdin=subprocess.PIPE, stderr=errors)
        try:
            yield child, errors
        finally:
            if child.poll() is None:  # it was not needed
                child.kill()
                child.communicate()


def start_all(
    wanted: Settings,
    parts: ExitStack,
    console: Console,
    opened: Callable[[str], None] = lambda address: None,
) -> "Running":
    """Start the virtual skin, if there is no hardware, the engine, the page and what is beside it.

    `parts` ends them all, the last one first. The page is `opened` as soon as it is served: the
    engine does not answer yet then.
    """
    loading = parts.enter_context(loading_engine())
    from skinfield.bridges.launch import bridges
    from skinfield.loop import State
    from skinfield.loop.client import Live
    from skinfield.loop.supervisor import Supervisor
    from skinfield.record.launch import recorder

    source, virtual = wanted.source, None
    with console.status("starting"):
        profile, settings_of = settings_by_source(wanted)
        settings = settings_of(source)  # refuses what it must before anything starts
        if source.hardware is None:
            virtual = parts.enter_context(virtual_skin(wanted, profile))
            settings = settings_of(on_virtual_boards(source, virtual.channels))
        supervisor = parts.enter_context(Supervisor(settings, loading))
        supervisor.wait(STARTS, State.STARTING).close()
        live = parts.enter_context(Live(settings.name))
        page = parts.enter_context(served_page(wanted, supervisor, virtual))
    opened(page.address)
    into = wanted.record.into
    if into is not None:
        Path(into).unlink(missing_ok=True)  # only --force lets it come so far
    parts.enter_context(recorder(settings.name, None if into is None else Path(into)))
    bridged = parts.enter_context(bridges(wanted.bridges, settings.name))

    def check() -> None:
        page.check()
        for text in (text for each in bridged for text in each.notices()):
            page.controller.say("warn", text)
            report.note(text, "yellow", console)

    scene = None if virtual is None else source.scene
    return Running(supervisor, live, page, scene, check)


def settings_by_source(
    wanted: Settings,
) -> tuple[SkinProfile, Callable[[SourceSettings], Any]]:
    """The profile in use, and what makes the settings of an engine for a source."""
    from skinfield.cli.sources import skin_for, source_from_options

    hardware, skin = wanted.source.hardware, options.skin_of(wanted.skin)
    profile = options.profile_in_use(wanted.skin, hardware, wanted.skin.first)
    answers, assumed = calibrated(wanted)
    skin = skin_for(hardware or "", skin)
    # without secrets; a virtual skin is started anew
    tree = changed(replace(wanted, page=PageSettings(), record=RecordSettings()))

    def settings_of(source: SourceSettings) -> Any:
        extra = source.named_options
        if wanted.skin.no_load is not None:  # the boards are sent it as well
            extra.setdefault("no_load", str(wanted.skin.no_load))
        hardware, bus = source.hardware or "icub", source.bus or ""
        stream = source_from_options(hardware, bus, source.channel, skin, extra)
        live = live_settings(replace(answers, source=source), profile, skin, stream, assumed)
        return replace(live, tree=tree)

    return profile, settings_of


class Running(NamedTuple):
    """A skin alive, and what is around it."""

    supervisor: Any
    live: Any
    page: Any
    scene: str | None  # what presses a virtual skin once it answers
    check: Callable[[], None]  # raises what ends the skin, and says what failed


def watch(
    running: Running, duration: float | None, screen: Any, console: Console
) -> dict[str, Any]:
    """Show the skin until its time is over, or Ctrl-C, and sum it up."""
    from skinfield.cli.status_table import draw
    from skinfield.loop.status import Observer

    live = running.live
    contacts: dict[int, dict[str, Any]] = {}
    said: dict[str, None] = {}
    patches = [patch.name for patch in live.skin]
    observer = Observer(live.reader, window=RECENT)
    try:
        began = _wait_running(running.supervisor, observer, screen, console)
        if failed := observer.look().notes.get("failed"):
            report.note(str(failed), "yellow", console)
        if running.scene is not None:
            running.page.controller.pressing.begin(running.scene)
        end = float("inf") if duration is None else began + duration
        drawn = began
        while time.monotonic() < end:
            newest = live.next(min(REFRESH, max(end - time.monotonic(), 0.0)))
            now = time.monotonic()
            running.check()
            if newest is not None:
                known = newest.contacts, patches, now - began, newest.solvers
                sum_up_contacts(contacts, *known)
            if now - drawn > REFRESH:
                drawn, status = now, observer.look()
                said.update(dict.fromkeys(status.sentences))
                if screen is not None:
                    draw(screen, status)
    except KeyboardInterrupt:
        report.note("stopping", where=console)
    finally:
        if screen is not None:
            screen.stop()
    return summary_of(observer.look(), running.supervisor, list(contacts.values()), list(said))


def sum_up_contacts(
    known: dict[int, dict[str, Any]],
    rows: NDArray[Any],
    patches: list[str],
    seconds: float,
    solvers: Sequence[str],
) -> None:
    """Take the contacts of one cycle, `seconds` after watching began, into those that are known.

    Each, by its track, is an object for JSON: `track` and `patch`; from `first_s` to `last_s`; the
    force `force_n` with `force_std_n` when it was surely the largest, one standard deviation less;
    and where and how it pressed then: `position_mm` in the patch's frame, `area_mm2`, `peak_kpa`;
    the `solver` that answered, of those of all patches; `shape` of what presses, `radius_mm` if
    known, and `maybe`: how many contacts in its place explain the readings nearly as well, 0 if
    none do.
    """
    from skinfield.estimate.row_contacts import shape_name

    now = round(seconds, DIGITS)
    for row in rows:
        track, force = int(row["track"]), round(float(row["normal_force"]), DIGITS)
        new = {"track": track, "patch": patches[int(row["patch"])], "first_s": now}
        contact = known.setdefault(track, new | {"force_n": 0.0, "force_std_n": None})
        contact["last_s"] = now
        std, radius = float(row["force_std"]), float(row["radius"])
        before = contact["force_n"], contact["force_std_n"]
        if sureness(force, std if np.isfinite(std) else None) >= sureness(*before):
            contact |= {
                "force_n": force,
                "force_std_n": round(std, DIGITS) if np.isfinite(std) else None,
                "position_mm": np.round(row["position"] * 1e3, DIGITS).tolist(),
                "area_mm2": round(float(row["area"]) * 1e6, DIGITS),
                "peak_kpa": round(float(row["peak_pressure"]) * 1e-3, DIGITS),
                "solver": solvers[int(row["patch"])],
                "shape": shape_name(row),
                "radius_mm": round(radius * 1e3, DIGITS) if np.isfinite(radius) else None,
                "maybe": int(row["maybe"]),
            }


def sureness(force: float, std: float | None) -> tuple[float, float]:
    """Rank of a force: what it surely is, less its standard deviation; else how large it is."""
    return (0.0 if std is None else max(force - std, 0.0)), force


def _wait_running(supervisor: Any, observer: Any, screen: Any, console: Console) -> float:
    """Wait until the engine answers by the solver asked for; the time then.

    Shows what it does meanwhile, such as answering linearly.
    """
    from skinfield.cli.status_table import draw
    from skinfield.loop.supervisor import EngineFailed

    began = moved = spoke = time.monotonic()
    before, silent = "", False
    while True:
        failed: EngineFailed | None = None
        now = time.monotonic()
        if not silent and now > began + SILENT:
            silent = True
            sources = observer.look().sources
            if names := [name for name, counts in sources.items() if not counts["received"]]:
                text = f"nothing has come from {', '.join(names)} yet, waiting: is it connected "
                report.note(text + "and on, and is --channel right?", "yellow", console)
        try:
            supervisor.wait(REFRESH).close()
            if not supervisor.start_in_words():
                return time.monotonic()
            time.sleep(LOOK)
        except EngineFailed as error:
            if supervisor.hopeless:
                raise
            failed = error
        doing = supervisor.start_in_words()
        moved = moved if doing == before else now
        if now > moved + STARTS:
            why = supervisor.failure or doing or "it has said nothing"
            raise EngineFailed(
                f"the engine is not ready after {now - began:.0f} s, {now - moved:.0f} s of "
                f"them without progress: {why}"
            ) from failed
        if screen is not None:
            draw(screen, observer.look())
        elif doing != before and now > spoke + SAYS:
            spoke = now
            report.note(f"{now - began:.0f} s: {doing}", where=console)
        before = doing


def summary_of(
    status: Any, supervisor: Any, contacts: list[dict[str, Any]], said: list[str]
) -> dict[str, Any]:
    """What `--json` prints; times in µs since the engine's start.

    `solver` is the engine's at the end, which answered linearly for `linear_s` before its contacts
    were prepared; `notes` is what it said of the readings of each patch.
    """
    return {
        **status.since.as_dict(),
        "scale": scale_of(status.relative),
        "lost": status.lost,
        "solver": status.notes.get("solver"),
        "linear_s": status.notes.get("linear_s"),
        "failed": status.notes.get("failed"),
        "contacts": contacts,
        "notes": said,
        "sources": status.sources,
        "restarts": supervisor.restarts,
        "granted": status.notes.get("granted"),
        "events": [[each.time_ns, each.what, each.text] for each in supervisor.events],
    }


def warmup(*, as_json: options.Json = False) -> None:
    """Compile, once for this machine, what a first `skinfield run` needs.

    It is such a run, of a virtual skin that is pressed, until the engine has answered. What
    it compiles stays in the user's cache folder, so that the next run starts within seconds. Where
    all is compiled already this takes a few seconds.

      skinfield warmup

    Parameters
    ----------
    as_json : bool
        How long it took, as one JSON object.
    """
    loop = LoopSettings(name=f"warmup-{os.getpid()}", priority=0)
    wanted, console = Settings(loop=loop, page=PageSettings(port=0)), Console(stderr=True)
    began = time.monotonic()
    with report.signals_end(), ExitStack() as parts:
        try:
            summary = watch(start_all(wanted, parts, console), SETTLE, None, console)
        finally:
            report.end_undisturbed()
    seconds, cycles = time.monotonic() - began, summary["cycles"]
    line = f"a run starts and answers: {cycles:,} cycles, {seconds:.0f} s in all"
    report.finish(as_json, {"seconds": seconds, "cycles": cycles}, lines=[line])

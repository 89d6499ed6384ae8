"""`skinfield emulate`: boards that do not exist, on a real bus."""

import signal
from typing import TYPE_CHECKING, Annotated, Any, Literal

from rich.console import Console

from skinfield.cli import options, report
from skinfield.settings import Elastomer
from skinfield.settings.tree import Range

if TYPE_CHECKING:
    from skinfield.emulator import VirtualSettings, VirtualSkin

MISHAPS = ("skipped", "lost", "duplicated", "swapped", "refused", "withheld")


WIRES, ELECTRONICS = options.heading("Wires"), options.heading("Electronics")
Share = Annotated[float, Range(0.0, 1.0, "a share of messages"), WIRES]


def emulate(
    *,
    hardware: Literal["icub", "cyskin", "packet"] = "icub",
    layout: options.LayoutText = "hexagon72",
    bus: str = "udp",
    channel: tuple[str, ...] = (),
    rate_hz: Annotated[float | None, Range(0.01, 20e3, "readings per second")] = None,
    at_once: bool = False,
    spread: bool = False,
    scene: str = "press",
    lead_in_s: Annotated[float, Range(0.0, 1e6, "seconds; 0: none")] = 3.0,
    duration: options.Duration = None,
    seed: options.Seed = 0,
    priority: Annotated[int, Range(0, 99, "of SCHED_FIFO; 0: not asked for")] = 0,
    control: str = "127.0.0.1:0",
    fault: tuple[str, ...] = (),
    truth: str = "",
    force: options.Force = False,
    as_json: options.Json = False,
    lose: Share = 0.0,
    duplicate: Share = 0.0,
    swap: Share = 0.0,
    delay_ms: Annotated[float, Range(0.0, 6e4, "ms; 0: none"), WIRES] = 0.0,
    jitter_us: Annotated[float, Range(0.0, 6e7, "µs; 0: none"), WIRES] = 20.0,
    noise_scale: Annotated[
        float, Range(0.0, 1e3, "times that of real boards; 0: none"), ELECTRONICS
    ] = 0.3,
    common_noise: Annotated[float, Range(0.0, 1e6, "counts; 0: none"), ELECTRONICS] = 0.0,
    gain_spread: Annotated[float, Range(0.0, 3.0, "of a logarithm; 0.1: 10 %"), ELECTRONICS] = 0.0,
    temperature: Annotated[str, ELECTRONICS] = "25",
    mtb3: Annotated[bool, ELECTRONICS] = False,
    elastomer: options.OfElastomer = Elastomer(),
) -> None:
    """Be a robot's skin: play the boards of one, on a real bus.

    Answer a host's configuration and send the very bytes that boards send, with readings from the
    forward simulation of presses.

      skinfield emulate --hardware icub --skin hexagon72
      skinfield run --hardware icub --skin hexagon72

    Boards of an iCub and of CySkin stream once a host has configured and started them, as real ones
    do; --at-once does not wait. Devices that send packets do so at once, ports of YARP once
    somebody reads them.

      BUS             HARDWARE      CHANNEL
      udp_multicast   icub, cyskin  group:port of python-can's virtual bus, 239.74.163.2:43113
      udp             icub, cyskin  host:port to be reached at; 127.0.0.1 and a free port
      socketcan       icub, cyskin  device, can0
      udp             packet        host:port that listens, 127.0.0.1:43210; or listen:host:port
      tcp             packet        host:port to be reached at, 127.0.0.1:43211
      tcp             yarp          host:port for a name server of its own, 127.0.0.1:10000; or
                                    register:host:port of a running one
      serial          packet        path of a link to the pseudo-terminal

    SCENE is idle, press, slide, two-balls, tap, random, or a file (.toml, .json) of presses in
    time; it begins --lead-in-s seconds after the first reading, so that a host can take its
    baseline. What really pressed, and when, goes to --truth FILE.

      skinfield emulate --scene random --seed 7 --truth truth.jsonl
      skinfield emulate --rate-hz 1000 --lose 0.001 --duplicate 0.001 --swap 0.001
      skinfield emulate --fault "unplug 3@10s" --fault "reboot 0@20s+2s" --fault "stuck 17@5s+10s"
      skinfield emulate --temperature 25..35@600s --noise-scale 1
      skinfield emulate --hardware packet --skin rectangular:rows=64,columns=64 --rate-hz 1000

    Faults are KIND NUMBER[@START][+SECONDS]: unplug (a triangle), reboot (a board), bus-off (a
    bus), dead, stuck, noisy, saturated, no-ack (a taxel); number 3 from 10 s after the first
    reading on, number 0 at 20 s for 2 s. NUMBER can be a run, 3-7, or all, *. Everything can also
    be asked for while it runs, by datagrams of JSON to the control address:
    {"do": "press", "x": 0.01, "y": 0, "force": 1}; see docs/virtual-skin.md.

    Readings that cannot be sent in time are skipped and counted, never sent late in a heap. Ctrl-C
    ends it with a summary.

    Parameters
    ----------
    hardware : str
        Whose boards.
    bus : str
        See above.
    channel : tuple of str
        Address on the bus, see above; once for each bus.
    rate_hz : float, 1/s, optional
        Readings of each board per second; default as the host asks, else the board's.
    at_once : bool
        Stream before a host says so.
    spread : bool
        Boards send one after the other.
    scene : str
        What presses, see above.
    lead_in_s : float, s
        Untouched at first, s.
    priority : int
        Of SCHED_FIFO, 1 to 99, where permitted.
    control : str
        Address for presses and faults from outside; empty for none.
    fault : tuple of str
        What fails, see above; again for more.
    truth : str
        File for what pressed, JSON lines.
    lose : float
        Share of messages that is lost, 0 to 1.
    duplicate : float
        Share that is sent twice.
    swap : float
        Share that follows the next one.
    delay_ms : float, ms
        From conversion to sending, ms.
    jitter_us : float, µs
        Mean random delay, µs.
    noise_scale : float
        Times the noise of a real skin; 0: none.
    common_noise : float
        Noise shared by a converter's taxels, counts.
    gain_spread : float
        Of the logarithm of gains, 0.1: 10 %.
    temperature : str
        °C: 25, 25..35@600s (rises in 600 s), 25~3@300s (± 3 K, period 300 s).
    mtb3 : bool
        iCub's older boards: drift rounds otherwise.
    """
    from skinfield.emulator import VirtualSettings, Wires, fault_from_text, temperature_from_text
    from skinfield.wire.can import PORT

    report.check_output("--truth", truth or None, force)
    faults = tuple(options.parsed("--fault", text, fault_from_text) for text in fault)
    warmth = options.parsed("--temperature", temperature, temperature_from_text)
    profile = options.profile_in_use(elastomer, hardware, layout)
    settings = VirtualSettings(
        hardware=hardware,
        skin=layout,
        bus=bus,
        channels=channel,
        port=PORT,
        rate=rate_hz,
        at_once=at_once,
        spread=spread,
        scene=scene,
        lead_in=lead_in_s,
        layer=options.layer_of(elastomer, profile),
        noise=noise_scale,
        common_noise=common_noise,
        gain_spread=gain_spread,
        temperature=warmth,
        mtb3=mtb3,
        wires=Wires(
            lose=lose,
            duplicate=duplicate,
            swap=swap,
            delay=delay_ms * 1e-3,
            jitter=jitter_us * 1e-6,
        ),
        faults=faults,
        seed=seed,
        control=control,
        truth=truth,
        duration=duration,
        priority=priority,
    )
    counts = _play(settings)
    if as_json:
        report.print_json(counts)
    else:
        _sum_up(counts)


def _play(settings: "VirtualSettings") -> dict[str, Any]:
    """Play a skin until its time is over, or it is stopped; what it did."""
    from skinfield.emulator import VirtualSkin

    skin = VirtualSkin(settings)
    before = {
        name: signal.signal(name, lambda *_: skin.stop())
        for name in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        patches = ", ".join(f"{patch.name} ({len(patch)} taxels)" for patch in skin.skin)
        report.note(f"{settings.hardware} skin: {patches}", "")
        where = ", ".join(skin.hardware.addresses)
        report.note(f"{settings.bus} at {where}; scene {skin.world.scene.name}", "")
        if skin.control_address:
            report.note(f"presses and faults: JSON by UDP to {skin.control_address}", "")
        report.say_notes(skin.notes)
        with Console(stderr=True).status("waiting for a host", spinner="dots") as status:
            skin.run(each_second=lambda each: status.update(_line_of(each)))
    finally:
        counts = {**skin.description(), **skin.counts()}
        skin.close()
        for name, handler in before.items():
            signal.signal(name, handler)
    return counts


def _line_of(skin: "VirtualSkin") -> str:
    """What is going on, in a line."""
    if not skin.stream_ns:
        return "waiting for a host"
    counts = skin.counts()
    rate = counts["readings"] / max(counts["streamed_seconds"], 1e-9)
    parts = [f"{counts['streamed_seconds']:.0f} s", f"{counts['messages']:,} messages"]
    parts.append(f"{rate:,.0f} readings/s")
    parts += [f"{counts[name]:,} {name}" for name in MISHAPS if counts[name]]
    presses = skin.pressing
    parts.append(
        ", ".join(f"{t.force:.2f} N at {t.x * 1e3:.1f} {t.y * 1e3:.1f} mm" for t in presses[:3])
        or "nothing presses"
    )
    return " | ".join(parts)


def _sum_up(counts: dict[str, Any]) -> None:
    """What was sent in all, and what became of it."""
    parts = [f"{counts['messages']:,} messages of {counts['readings']:,} readings sent"]
    report.note(", ".join(parts + [f"{counts[name]:,} {name}" for name in MISHAPS]), "")
    if counts["faults"]:
        began = ", ".join(f"{kind} {count}" for kind, count in counts["faults"].items())
        report.note(f"faults that began: {began}", "")
    if counts["skipped"]:
        report.note(
            f"{counts['skipped']:,} readings came too late and were skipped: this machine was "
            "too busy for the rate",
            "yellow",
        )
    if counts["refused"] and not counts["messages"]:
        where = ", ".join(counts["channels"])
        report.note(f"nothing went out: no host has spoken to {where}", "yellow")
    report.say_notes(counts["notes"])

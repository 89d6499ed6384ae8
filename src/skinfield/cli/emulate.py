"""`skinfield emulate`: boards that do not exist, on a real bus."""

import signal
from typing import TYPE_CHECKING, Annotated, Any

from rich.console import Console

from skinfield.cli import options, report
from skinfield.cli.settings import Elastomer
from skinfield.emulator.settings import EmulatedBoards, VirtualSettings, Wires

if TYPE_CHECKING:
    from skinfield.emulator.skin import VirtualSkin

MISHAPS = ("skipped", "lost", "duplicated", "swapped", "refused", "withheld")


def emulate(
    *,
    boards: Annotated[EmulatedBoards, options.part("Boards")] = EmulatedBoards(),
    force: options.Force = False,
    as_json: options.Json = False,
    wires: Annotated[Wires, options.part("Wires")] = Wires(),
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
    {"do": "press", "x": 0.01, "y": 0, "force": 1}; see docs/how-to/virtual-skin.md.

    Readings that cannot be sent in time are skipped and counted, never sent late in a heap. Ctrl-C
    ends it with a summary.
    """
    from skinfield.wire.can import PORT

    report.check_output("--truth", boards.truth or None, force)
    profile = options.profile_in_use(elastomer, boards.hardware, boards.skin)
    layer = options.layer_of(elastomer, profile)
    settings = VirtualSettings(**vars(boards), port=PORT, layer=layer, wires=wires)
    counts = _play(settings)
    if as_json:
        report.print_json(counts)
    else:
        _sum_up(counts)


def _play(settings: VirtualSettings) -> dict[str, Any]:
    """Play a skin until its time is over, or it is stopped; what it did."""
    from skinfield.emulator.skin import VirtualSkin

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

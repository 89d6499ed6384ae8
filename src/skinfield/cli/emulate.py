"""`skinfield emulate`: boards that do not exist, on a real bus."""

import json
import signal
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click
from rich.console import Console

from skinfield.cli.emulate_report import introduce, line_of, sum_up
from skinfield.cli.inputs import LAYOUT_HELP
from skinfield.cli.options import layer_from_options, layer_options

if TYPE_CHECKING:
    from skinfield.virtual import Fault, VirtualSettings

F = TypeVar("F", bound=Callable[..., Any])
FAULTS = {  # flags that take WHAT[@START][+SECONDS], and what WHAT is the number of
    "unplug": "Triangle (or BOARD.TRIANGLE) that is unplugged.",
    "reboot": "Board that is silent, by default for 2s, and must then be configured anew.",
    "bus-off": "Bus that is gone.",
    "dead": "Taxel (or PATCH/TAXEL) that sends its count at rest.",
    "stuck": "Taxel that keeps its count.",
    "noisy": "Taxel with ten times the noise.",
    "saturated": "Taxel at the clamp of full load.",
    "no-ack": "Taxel whose converter does not answer.",
}


def fault_options(function: F) -> F:
    """One flag for each kind of fault."""
    for name in reversed(FAULTS):
        flag = click.option(
            f"--{name}", metavar="WHAT[@START][+SECONDS]", multiple=True, help=FAULTS[name]
        )
        function = flag(function)
    return function


def wire_options(function: F) -> F:
    """What happens to messages on their way."""
    chance = click.FloatRange(0.0, 1.0)
    for option in (
        click.option("--jitter-us", default=20.0, show_default=True, help="Mean random delay, µs."),
        click.option("--delay-ms", default=0.0, help="From conversion to sending, ms."),
        click.option("--swap", type=chance, default=0.0, help="Share that follows the next one."),
        click.option("--duplicate", type=chance, default=0.0, help="Share that is sent twice."),
        click.option("--lose", type=chance, default=0.0, help="Share of messages that is lost."),
    ):
        function = option(function)
    return function


def electronics_options(function: F) -> F:
    """Noise, spread and warmth."""
    for option in (
        click.option("--mtb3", is_flag=True, help="iCub's older boards: drift rounds otherwise."),
        click.option(
            "--temperature",
            metavar="PROFILE",
            default="25",
            show_default=True,
            help="°C: 25, 25..35@600s (rises in 600 s), 25~3@300s (± 3 K, period 300 s).",
        ),
        click.option("--gain-spread", default=0.0, help="Of the logarithm of gains, 0.1: 10 %."),
        click.option("--common-noise", default=0.0, help="Shared by a converter's taxels, counts."),
        click.option(
            "--noise", default=0.3, show_default=True, help="Times that of a real skin; 0: none."
        ),
    ):
        function = option(function)
    return function


def place_options(function: F) -> F:
    """Whose boards, of which skin, on which bus, how fast."""
    for option in (
        click.option("--spread", is_flag=True, help="Boards send one after the other."),
        click.option("--at-once", is_flag=True, help="Stream before a host says so."),
        click.option(
            "--rate",
            type=float,
            help="Readings of each board per second; default as the host asks, else the board's.",
        ),
        click.option(
            "--channel",
            "channels",
            multiple=True,
            help="Address on the bus, see above; once for each bus.",
        ),
        click.option(
            "--bus", default=None, help="See above; default udp_multicast, packets: udp, yarp: tcp."
        ),
        click.option(
            "--skin", metavar="LAYOUT", default="hexagon72", show_default=True, help=LAYOUT_HELP
        ),
        click.option(
            "--hardware",
            type=click.Choice(["icub", "cyskin", "packet", "yarp"]),
            default="icub",
            show_default=True,
            help="Whose boards.",
        ),
    ):
        function = option(function)
    return function


def run_options(function: F) -> F:
    """How it is run and followed."""
    for option in (
        click.option("--json", "as_json", is_flag=True, help="One JSON object at the end."),
        click.option("--truth", metavar="FILE", default="", help="Write what pressed, JSON lines."),
        click.option(
            "--control",
            default="127.0.0.1:0",
            show_default=True,
            help="Address for presses and faults from outside; empty for none.",
        ),
        click.option("--priority", default=0, help="Of SCHED_FIFO, 1 to 99, where permitted."),
        click.option("--seed", default=0, show_default=True, help="Of all that is random."),
        click.option("--duration", type=float, help="Seconds; default until Ctrl-C."),
    ):
        function = option(function)
    return function


@click.command(
    short_help="Be a skin: boards that do not exist, on a real bus.",
    help="""Be a robot's skin: answer a host's configuration and send the very bytes that boards
send, with readings from the forward simulation of presses.

\b
  skinfield emulate --hardware icub --skin hexagon72 --bus udp_multicast
  skinfield run --hardware icub --skin hexagon72 --bus udp_multicast

Boards of an iCub and of CySkin stream once a host has configured and started them, as real ones
do; --at-once does not wait. Devices that send packets do so at once, ports of YARP once somebody
reads them.

\b
BUS             HARDWARE      CHANNEL
udp_multicast   icub, cyskin  group:port of python-can's virtual bus, 239.74.163.2:43113
udp             icub, cyskin  host:port to be reached at; 127.0.0.1 and a free port
socketcan       icub, cyskin  device, can0
udp             packet        host:port that listens, 127.0.0.1:43210; or listen:host:port
tcp             packet        host:port to be reached at, 127.0.0.1:43211
tcp             yarp          host:port for a name server of its own, 127.0.0.1:10000; or
                              register:host:port of a running one
serial          packet        path of a link to the pseudo-terminal

SCENE is idle, press, slide, two-balls, tap, random, or a file (.toml, .json) of presses in time; it
begins --lead-in seconds after the first reading, so that a host can take its baseline. What really
pressed, and when, goes to --truth FILE.

\b
  skinfield emulate --scene random --seed 7 --truth truth.jsonl
  skinfield emulate --rate 1000 --lose 0.001 --duplicate 0.001 --swap 0.001
  skinfield emulate --unplug 3@10s --reboot 0@20s+2s --stuck 17@5s+10s
  skinfield emulate --temperature 25..35@600s --noise 1
  skinfield emulate --hardware packet --skin rectangular:rows=64,columns=64 --rate 1000

Faults are WHAT[@START][+SECONDS]: number 3 from 10 s after the first reading on, number 0 at 20 s
for 2 s. WHAT can be a run, 3-7, or all, *. Everything can also be asked for while it runs, by
datagrams of JSON to the control address: {"do": "press", "x": 0.01, "y": 0, "force": 1}; see
docs/virtual-skin.md.

Readings that cannot be sent in time are skipped and counted, never sent late in a heap. Ctrl-C ends
it with a summary.
""",
)
@place_options
@click.option("--scene", default="press", show_default=True, help="What presses, see above.")
@click.option("--lead-in", default=3.0, show_default=True, help="Untouched at first, seconds.")
@wire_options
@electronics_options
@fault_options
@layer_options
@run_options
def emulate(**options: Any) -> None:
    """Play a skin until it is told to stop."""
    from skinfield.virtual import VirtualSkin

    settings = _settings(options)
    skin = VirtualSkin(settings)
    before = {name: signal.getsignal(name) for name in (signal.SIGINT, signal.SIGTERM)}
    for name in before:
        signal.signal(name, lambda *_: skin.stop())
    shown = Console(stderr=True)
    try:
        introduce(skin, shown)
        with shown.status("waiting for a host", spinner="dots") as status:
            skin.run(each_second=lambda each: status.update(line_of(each)))
    finally:
        counts = {**skin.description(), **skin.counts()}
        skin.close()
        for name, handler in before.items():
            signal.signal(name, handler)
    if options["as_json"]:
        click.echo(json.dumps(counts))
    else:
        sum_up(counts, shown)


def _settings(options: dict[str, Any]) -> "VirtualSettings":
    from skinfield.virtual import VirtualSettings, Wires, temperature_from_text

    usual = {"packet": "udp", "yarp": "tcp"}.get(options["hardware"], "udp_multicast")
    return VirtualSettings(
        hardware=options["hardware"],
        skin=options["skin"],
        bus=options["bus"] or usual,
        channels=options["channels"],
        rate=options["rate"],
        at_once=options["at_once"],
        spread=options["spread"],
        scene=options["scene"],
        lead_in=options["lead_in"],
        layer=layer_from_options(
            options["thickness_mm"], options["modulus_kpa"], options["poisson"]
        ),
        noise=options["noise"],
        common_noise=options["common_noise"],
        gain_spread=options["gain_spread"],
        temperature=temperature_from_text(options["temperature"]),
        mtb3=options["mtb3"],
        wires=Wires(
            lose=options["lose"],
            duplicate=options["duplicate"],
            swap=options["swap"],
            delay=options["delay_ms"] * 1e-3,
            jitter=options["jitter_us"] * 1e-6,
        ),
        faults=_faults(options),
        seed=options["seed"],
        control=options["control"],
        truth=options["truth"],
        duration=options["duration"],
        priority=options["priority"],
    )


def _faults(options: dict[str, Any]) -> tuple["Fault", ...]:
    from skinfield.virtual import fault_of

    return tuple(
        fault_of(name, text) for name in FAULTS for text in options[name.replace("-", "_")]
    )

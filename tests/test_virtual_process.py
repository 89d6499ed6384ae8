"""Virtual skins in processes of their own, over real sockets."""

import json
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused
from live_skins import wait_for
from test_readme import doc, follow
from virtual_host import LONG, START, Host, bytes_by_channel

from skinfield.emulator import VirtualSettings, VirtualSkin
from skinfield.emulator.process import start
from skinfield.emulator.transports import Request
from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Count
from skinfield.skin import Skin
from skinfield.skin.generators import by_name
from skinfield.wire.can import BusSettings
from skinfield.wire.cyskin import on_boards
from skinfield.wire.sources.boards import CySkinCan
from skinfield.wire.sources.packets import PacketSerial, PacketTcp, PacketUdp

PATCH = by_name("hexagon72")
MISHAPS = ("lost", "duplicated", "swapped")
STILL = {"scene": "idle", "noise_scale": 0.0, "rate": 100.0}


def gone(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


@pytest.fixture(scope="module")
def icub():
    """One process for several tests; each leaves it as it was."""
    with start(VirtualSettings(bus="udp", **STILL)) as skin:
        yield skin


def silence(icub, host):
    """Stop the boards, and wait until they have taken that in."""
    commands = icub.counts()["commands"]
    host.tell("07 01")
    wait_for(lambda: icub.counts()["commands"] > commands)


@pytest.fixture
def host(icub):
    host = Host(icub.channels[0])
    host.tell(*START)
    host.wait_for(12)
    yield host
    silence(icub, host)
    icub.release()
    host.close()


def test_what_arrives_is_what_it_says_it_sent(icub, host):
    silence(icub, host)
    host.messages()
    before = icub.counts()
    icub.wires(lose=0.04, duplicate=0.04, swap=0.04)
    host.tell("07 00")
    messages = host.wait_for(1500)
    host.tell("07 01")
    wait_for(lambda: icub.counts()["commands"] == before["commands"] + 2)
    counts = icub.counts()
    icub.wires(lose=0.0, duplicate=0.0, swap=0.0)
    more = {name: counts[name] - before[name] for name in ("messages", "readings", *MISHAPS)}
    messages += host.wait_for(more["messages"] - len(messages))
    assert len(messages) == more["messages"]
    kept = 12 * more["readings"] - more["messages"] - more["lost"] + more["duplicated"]
    assert kept in (0, 1)  # a swapped one may wait for the next
    assert min(more[name] for name in MISHAPS) > 10
    assert bytes_by_channel(messages)[:72].tolist() == [240] * 72


def test_presses_from_outside_are_felt_and_known(icub, host):
    made = len(icub.truth())
    name = icub.press(taxel=30, force=1.0)
    wait_for(lambda: bytes_by_channel(host.wait_for(12))[30] < 230)
    x, y = PATCH.plane[60]
    icub.move(name, x, y, force=2.0)
    wait_for(lambda: bytes_by_channel(host.wait_for(24))[30] == 240)
    assert bytes_by_channel(host.wait_for(24))[60] < 220
    icub.release(name)
    wait_for(lambda: bytes_by_channel(host.wait_for(24))[60] == 240)
    lines = icub.truth(made)
    presses = [[(p["id"], p["force"]) for p in line["presses"]] for line in lines]
    assert presses == [[(name, 1.0)], [(name, 2.0)], []]
    np.testing.assert_allclose(lines[1]["presses"][0]["position"], PATCH.positions[60])
    stamps = [line["stamp_ns"] for line in lines]
    assert stamps == sorted(stamps)
    assert abs(stamps[-1] - time.time_ns()) < LONG * 1e9
    with pytest.raises(InputError, match="id is 'nobody'"):
        icub.move("nobody", 0.0, 0.0)
    with pytest.raises(InputError, match="expected above 0 and at most"):
        icub.press(taxel=1, force=5000.0)


def test_faults_and_scenes_from_outside(icub, host):
    icub.fault("dead 3-5")
    icub.fault("unplug 2")
    wait_for(lambda: bytes_by_channel(host.wait_for(12))[24] == 0)
    icub.clear("unplug")
    wait_for(lambda: bytes_by_channel(host.wait_for(12))[24] == 240)
    icub.clear()
    icub.scene("press")
    assert icub.ask({"do": "describe"})["scene"] == "press"
    icub.scene("idle")
    assert icub.counts()["faults"] == {"dead": 1, "unplug": 1}
    for text in ("unplug 9", "explode 1", "dead 72"):
        with pytest.raises(InputError, match="expected"):
            icub.fault(text)


@contextmanager
def beside(settings):
    """A virtual skin in a thread of this process, which costs no start of another one."""
    skin = VirtualSkin(settings)
    thread = threading.Thread(target=skin.run)
    thread.start()
    try:
        yield skin
    finally:
        skin.stop()
        thread.join()
        skin.close()


@pytest.mark.parametrize("bus", ["tcp", "serial", "udp"])
def test_packets_arrive_by_every_road(bus, tmp_path):
    channels = {"tcp": "127.0.0.1:0", "serial": str(tmp_path / "skin"), "udp": "listen"}
    settings = VirtualSettings(hardware="packet", bus=bus, channels=(channels[bus],), **STILL)
    with beside(settings) as skin:
        where = skin.hardware.addresses[0]
        source = {
            "tcp": lambda: PacketTcp(72, port=int(where.rpartition(":")[2])),
            "serial": lambda: PacketSerial(72, path=where),
            "udp": lambda: PacketUdp(72, port=0, peer=where),
        }[bus]()
        feels(source, skin, rest=1000.0)
    assert not (tmp_path / "skin").is_symlink()


def test_cyskin_is_configured_and_streams():
    settings = VirtualSettings(hardware="cyskin", bus="udp", **STILL)
    boards = on_boards(Skin((PATCH,)))[1]
    with beside(settings) as skin:
        peer = skin.hardware.addresses[0]
        source = CySkinCan(boards, (BusSettings("udp", port=0, peer=peer),))
        feels(source, skin, rest=0.0)


def feels(source, skin, rest):
    """The stream of a source shows a press where it is, and loses nothing."""
    stream = source.open()
    channels, blocks = Channels(72), Blocks()

    def read():
        blocks.clear()
        stream.poll(blocks, 0, time.time_ns())
        channels.apply(blocks)
        return channels.counts

    wait_for(lambda: np.nan_to_num(read(), nan=-1.0).min() >= 0.0)
    assert (channels.counts == rest).all()
    skin.world.press(Request(taxel=33, force=4.0))
    wait_for(lambda: read()[33] > rest + 3000)
    assert np.argmax(channels.counts) == 33
    assert stream.counters[Count.LOST] == stream.counters[Count.MALFORMED] == 0
    stream.close()


def test_it_ends_when_the_process_that_started_it_is_killed():
    script = (
        "import sys, time; from skinfield.emulator import VirtualSettings;"
        "from skinfield.emulator.process import start;"
        "skin = start(VirtualSettings(bus='udp', scene='idle'));"
        "print(skin.pid, flush=True); time.sleep(600)"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as parent:
        pid = int(parent.stdout.readline())
        assert not gone(pid)
        parent.kill()
    wait_for(lambda: gone(pid))


def test_settings_that_cannot_be_used_are_said_where_it_was_started():
    with pytest.raises(InputError, match=r"did not start: skim: no such file"):
        start(VirtualSettings(skin="skim"))


def test_the_command_says_what_it_sent(tmp_path):
    truth = tmp_path / "truth.jsonl"
    words = ["emulate", "--hardware", "packet", "--channel", "127.0.0.1:9", "--duration", "0.7"]
    words += ["--rate-hz", "100", "--fault", "unplug 1@1ms", "--truth", str(truth), "--json"]
    result = invoke(words)
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout.splitlines()[-1])
    assert said["readings"] > 0
    assert said["messages"] == said["readings"] + 1  # and the hello
    assert said["faults"] == {"unplug": 1}
    assert [json.loads(line)["number"] for line in truth.read_text().splitlines()] == [0]


def test_the_command_ends_with_a_summary_when_it_is_told_to():
    words = [sys.executable, "-c", "from skinfield.cli.main import main; main()"]
    words += ["emulate", "--channel", "127.0.0.1:0", "--scene", "idle"]
    with ExitStack() as ends:
        commands = [
            ends.enter_context(subprocess.Popen(words, stderr=subprocess.PIPE, text=True))
            for _ in range(2)
        ]
        for command, number in zip(commands, (signal.SIGINT, signal.SIGTERM), strict=True):
            said = iter(command.stderr.readline, "")
            assert any("JSON by UDP" in line for line in said)
            command.send_signal(number)
            rest = command.stderr.read()
            assert command.wait() == 0
            assert "0 messages of 0 readings sent" in rest
            assert "Traceback" not in rest


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--fault", "unplug 9"], "triangle is '9', expected a number from 0 to 5"),
        (["--scene", "dance"], "scene is 'dance', expected one of idle"),
        (["--hardware", "packet", "--bus", "can"], "bus is 'can', expected one of"),
        (["--skin", "skim"], "skim: no such file"),
        (["--rate-hz", "0"], "--rate-hz is 0.0, expected a number from 0.01"),
    ],
)
def test_what_the_command_cannot_use_is_said(words, said):
    assert said in refused("emulate", "--channel", "127.0.0.1:0", *words)


def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = doc("virtual-skin")
    assert follow(page) == (1, 1)
    assert Path("truth.jsonl").read_text()

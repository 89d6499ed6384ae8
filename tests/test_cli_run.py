"""`skinfield run` as people start it: wrong options, and every way to end."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import mcap_sample
import numpy as np
import pytest
from command_line import refused, result_of, run
from live_skins import unique_name, wait_for
from websockets.sync.client import ClientConnection, connect

import skinfield as sf
from skinfield.calibrate import TouchCalibration, save_calibration
from skinfield.cli.report import end_undisturbed, signals_end
from skinfield.cli.settings import RecordSettings, load_settings
from skinfield.errors import InputError
from skinfield.files.mcap.live import LiveRecording
from skinfield.loop.slots import CycleHead
from skinfield.page.settings import PageSettings
from skinfield.ring import Field, Ring, RingReader, State
from skinfield.signal import Calibration, ICubByte

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
FOLDER = Path("/dev/shm")
TOKEN = ("--token", "a-long-token")
CODE = (
    "import signal\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it\n"
    "from skinfield.cli.main import main; main()\n"
)
COMMAND = (sys.executable, "-c", CODE)
QUICK = ("--skin", "icub_triangle", "--grid", "10", "--rate-hz", "100", "--headless")


def left_of(name: str) -> list[str]:
    """Files that bear a skin's name."""
    return [each.name for each in FOLDER.iterdir() if each.name.endswith(f".{name}")]


def children_of(pid: int) -> list[int]:
    """Processes that a process has started."""
    found = []
    for each in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = each.read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        if int(fields[1]) == pid:
            found.append(int(each.parent.name))
    return found


def lives(pid: int) -> bool:
    """Whether a process is there and not a zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--skin", "no_such_layout"), "no such file, and no generator"),
        (("--hardware", "robotnik"), "robotnik"),
        (("--port", "99999"), "--port is 99999, expected a whole number from 0 to 65535"),
        (("--host", 70 * "x", *TOKEN), "xx cannot be served: "),
        (("--host", "192.0.2.1", *TOKEN), "of 192.0.2.1 cannot be served: Cannot assign"),
        (("--host", "0.0.0.0"), "expected 8 or more: whoever opens the page"),
        (("--record", "/no-such-folder/a.mcap"), "is no folder, expected one that is there"),
        (("--record", "a.txt"), "expected a name that ends in .mcap"),
        (("--record", __file__), "which is there already, expected a new file"),
        (("--rate-hz", "0"), "--rate-hz is 0.0, expected a finite number above 0"),
        (("--rate-hz", "nan"), "--rate-hz is nan, expected a finite number above 0"),
        (("--rate-hz", "1e9"), "expected 100000 cycles per second at most"),
        (("--deadline-us", "5000"), "expected less than the period of 1000 µs"),
        (("--duration", "-1"), "--duration is -1.0, expected a finite number above 0: seconds"),
        (("--name", "a/b"), "a/b"),
        (("--scene", "nonsense"), "expected one of idle, press"),
        (("--grid", "2"), "--grid is 2, expected a whole number from 4"),
        (("--set", "x"), "expected KEY=VALUE"),
        (("--priority", "200"), "200"),
        (("--cpu", "-1"), "-1"),
        (("--gain", "0"), "--gain is 0.0, expected counts"),
        (("--virtual-rate-hz", "0"), "--virtual-rate-hz is 0.0, expected"),
        (("--solver", "contacts"), 'Invalid value "contacts" for --solver'),
        (("--zenoh-listen", "tcp/:7447"), "expected zenoh or ros2 with them"),
        (("--ros-rate", "wrench=5"), "--ros-rate was given, expected ros2 with it"),
    ],
)
def test_wrong_options_are_refused_before_anything_starts(
    options: tuple[str, ...], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def start(*_: object, **__: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr("skinfield.emulator.process.start", start)
    monkeypatch.setattr("skinfield.loop.supervisor.Supervisor.__enter__", start)
    name = () if "--name" in options else ("--name", unique_name())
    assert said in refused("run", "--headless", *name, *options)


@pytest.mark.parametrize("host", ["127.0.0.1", "127.0.0.2", "localhost"])
def test_a_taken_port_is_refused(host: str) -> None:
    words = ["run", "--name", unique_name(), "--host", host, "--port"]
    with socket.create_server((host, 0)) as taken:
        said = refused(*words, taken.getsockname()[1])
    assert "cannot be served: Address already in use" in said


def test_a_running_name_is_refused() -> None:
    with Ring.create(unique_name(), [Field("x", "<f8", (1,))]) as ring:
        assert f"a skin named '{ring.name}' runs already" in refused("run", "--name", ring.name)
        ring.unlink()


def test_a_recording_without_settings_is_refused(tmp_path: Path) -> None:
    mcap_sample.write(tmp_path / "a.mcap")
    said = refused("run", tmp_path / "a.mcap")
    assert "a.mcap holds no settings, expected a recording of `skinfield run`" in said


class Running:
    """A `skinfield run` of its own process group."""

    def __init__(self, name: str, *options: str) -> None:
        self.name = name
        tare = () if "--tare-s" in options else ("--tare-s", "0.2")
        words = [*COMMAND, "run", "--name", name, "--priority", "0", *QUICK, *tare, *options]
        self.process = subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        self.seen: set[int] = set()

    def wait_for(self, condition: Callable[[], object]) -> None:
        """Wait for it, noting what processes there are meanwhile."""

        def met() -> object:
            assert self.process.poll() is None, self.process.communicate()
            self.seen.update(children_of(self.process.pid))
            return condition()

        wait_for(met, 600.0)

    def is_at(self, *states: State) -> bool:
        """Whether the engine is in one of these states."""
        try:
            with RingReader(self.name) as reader:
                return reader.state in states
        except InputError:
            return False

    def feels(self) -> bool:
        """Whether its virtual skin is pressed, which begins when all that it starts is there."""
        try:
            with RingReader(self.name) as reader:
                slot = reader.latest()
                if slot is None or slot.generation != reader.generation or not reader.alive:
                    return False  # of an engine that ran before on this ring
                return bool(slot["head"][CycleHead.CONTACTS]) and reader.state == State.RUNNING
        except InputError:
            return False

    def opened(self, port: int) -> ClientConnection:
        """A browser of its page, for which a recorder stands ready."""
        before = {pid for pid in self.seen if records(pid)}
        browser = connect(f"ws://127.0.0.1:{port}/socket")
        self.wait_for(lambda: any(records(pid) for pid in self.seen - before))
        return browser

    def all_gone(self) -> bool:
        """Whether none of its processes is left."""
        return not any(lives(each) for each in self.seen)


def records(pid: int) -> bool:
    """Whether a process is a recorder, or stands ready to be one."""
    try:
        return b"skinfield.record.recorder" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False


def serves(port: int) -> bool:
    """Whether a page is there."""
    with socket.socket() as found:
        return found.connect_ex(("127.0.0.1", port)) == 0


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


@contextmanager
def running(*options: str, name: str = "") -> Iterator[Running]:
    found = Running(name or unique_name(), *options)
    try:
        yield found
    finally:
        found.seen.update(children_of(found.process.pid))
        if found.process.poll() is None:
            found.process.kill()
        found.process.communicate()
        for each in filter(lives, found.seen):
            os.kill(each, signal.SIGKILL)
        for each in left_of(found.name):
            (FOLDER / each).unlink()


def ends(found: Running, number: int) -> tuple[str, str]:
    """Send a signal, as a terminal does it to the whole group; what was said until the end."""
    os.killpg(found.process.pid, number)
    said = found.process.communicate(timeout=300)
    wait_for(found.all_gone)
    assert left_of(found.name) == []
    assert "Traceback" not in said[1]
    return said


def test_sigterm_while_it_starts_leaves_nothing() -> None:
    with running() as found:
        found.wait_for(lambda: found.seen)  # the virtual skin
        ends(found, signal.SIGTERM)
        assert found.process.returncode != 0


def test_a_closed_terminal_while_it_calibrates_leaves_nothing(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    with running("--tare-s", "100", "--record", str(file), *TOKEN) as found:
        found.wait_for(lambda: found.is_at(State.CALIBRATING) and file.exists())
        assert len(found.seen) >= 3
        ends(found, signal.SIGHUP)
    assert whole(file)
    saved = tmp_path / "as_recorded.toml"
    run("run", file, "--save", saved)
    settings = load_settings(saved)  # those of the run, but for the page's, with their secrets
    assert (settings.loop.tare_s, settings.model.grid) == (100.0, 10)
    assert (settings.page, settings.record) == (PageSettings(), RecordSettings())


def whole(path: Path) -> bool:
    """Whether an MCAP file has its end."""
    data = path.read_bytes()
    return data[:8] == data[-8:] == b"\x89MCAP0\r\n"


def test_killed_it_leaves_no_process_and_the_next_takes_over(tmp_path: Path) -> None:
    file, second, port = tmp_path / "a.mcap", tmp_path / "b.mcap", free_port()
    with running("--record", str(file), "--port", str(port)) as found:
        found.wait_for(lambda: found.is_at(State.RUNNING) and file.exists())
        assert len(found.seen) >= 3  # virtual skin, engine, recorder
        found.wait_for(lambda: serves(port))
        found.opened(port)
        found.process.kill()
        found.process.communicate()
        wait_for(found.all_gone)
        assert whole(file)  # the recorder was told, and finished it
        check_ctrl_c_while_it_runs(found.name, second)


def check_ctrl_c_while_it_runs(name: str, file: Path) -> None:
    """On a ring that was left behind, whose engine had a baseline."""
    port = free_port()
    with running("--json", "--record", str(file), "--port", str(port), name=name) as found:
        found.wait_for(found.feels)
        assert sum(map(records, found.seen)) == 1  # nobody looks on
        found.opened(port)
        text, errors = ends(found, signal.SIGINT)
        assert found.process.returncode == 0, errors
        said = json.loads(text)
    assert said["cycles"] > 0
    assert {"late", "lost", "latency_us", "wake_us", "contacts"} <= set(said)
    assert whole(file)


def told_twice() -> None:
    with signals_end():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
        finally:
            end_undisturbed()
            os.kill(os.getpid(), signal.SIGTERM)


def test_signals_are_as_before_when_a_command_has_ended() -> None:
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.getsignal(each) for each in numbers]
    with pytest.raises(KeyboardInterrupt):
        told_twice()
    assert [signal.getsignal(each) for each in numbers] == before


def test_a_calibration_by_touch_is_taken_live_and_by_its_recording(tmp_path: Path) -> None:
    patch = sf.layouts.icub_triangle()
    counts = Calibration.from_convention(patch, ICubByte(), gain=-171.0, noise_std=0.6)
    known = {"thickness": 1.7e-3, "poisson_ratio": 0.48, "young_modulus": 150e3, "covered": True}
    known |= {"gain": np.full(12, 1.25), "gain_std": np.ones(12), "noise_std": np.full(12, 3e-3)}
    known |= {"thickness_std": 1e-5, "poisson_std": 1e-3, "model_error": 0.0, "presses": 99}
    made = TouchCalibration(**known, left_out=0, force_ratio=float("nan"))
    cal, file = tmp_path / "cal.toml", tmp_path / "a.mcap"
    save_calibration(made.with_counts(counts), cal)
    words = (*QUICK, "--name", unique_name(), "--port", "0", "--priority", "0")
    chosen = ("--calibration", cal, "--without", "3,5-6", "--keep", "4")
    live = ("run", *words, *chosen, "--record", file, "--duration", "0.3")
    assert result_of(*live)["scale"] == "relative"
    found = LiveRecording.open(file)
    own = found.calibrations[patch.name]
    assert found.relative
    assert found.configuration["mechanics"]["inextensible_cover"] is True
    assert found.configuration["layer"]["thickness"] == pytest.approx(1.7e-3)
    assert np.flatnonzero(~own.alive).tolist() == [3, 5, 6]
    assert own.gain[own.alive] == pytest.approx(-171.0 * 1.25)
    summary = result_of("reconstruct", file, "--skin", file)
    assert summary["scale"] == "relative"
    assert summary["taxels_left_out"] == 3
    assert "thickness 1.70 mm" in summary["layer"]
    assert summary["options"]["mechanics"] == "covered-layer"


@pytest.mark.parametrize(
    ("made", "said"),
    [
        ("force", "which holds a ForceCalibration, expected one of counts or by touches"),
        ("other", "has 12 taxels, expected 72"),
        (None, "cannot be read"),
    ],
)
def test_what_no_live_skin_can_take_is_refused(made: str | None, said: str, tmp_path: Path) -> None:
    patch, cal = sf.layouts.hexagon72(), tmp_path / "cal.toml"
    if made == "force":
        rng = np.random.default_rng(0)
        counts = 100.0 + 40.0 * rng.random((60, 72))
        save_calibration(sf.calibrate.force(patch, counts, counts.sum(axis=1) / 1e3), cal)
    elif made == "other":
        other = sf.layouts.icub_triangle()
        save_calibration(Calibration.identity(other, noise_std=0.01), cal)
    assert said in refused("run", "--calibration", cal, "--headless", "--port", "0")

"""The C header against the Python reader, and the page on the ring: its programs run."""

import errno
import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from ring_scenes import LOG_BYTES, SLOT, SLOTS, bytes_of, compiled, own_name, worker, write

from skinfield.ring import Field, Ring, RingReader, State, include_folder

HERE = Path(__file__).resolve().parent
EXAMPLE = HERE.parent / "examples" / "c" / "ring_watch.c"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(HERE / "ring_reader.c", tmp_path_factory.mktemp("c"), "-std=c11")


def seen(program: Path, path: Path) -> list[list[str]]:
    result = subprocess.run([program, path], capture_output=True, text=True, timeout=60)
    return [line.split(" ", 1) for line in result.stdout.splitlines()]


def test_c_sees_what_python_sees(program: Path, tmp_path: Path) -> None:
    fields = (*SLOT, Field("place", "f4", (3, 5)), Field("valid", "?", (7,)))
    status = (Field("late", "u8", (4,)), Field("load", "f8"))
    rng, batches = np.random.default_rng(1), []
    with Ring.create("c", fields, status, {"skin": "µ"}, 4, 4096, folder=tmp_path) as ring:
        for _ in range(6):
            slot = ring.begin()
            for array in slot.values():
                array[...] = rng.integers(0, 100, array.shape)
            batches.append(rng.integers(0, 256, 777, dtype=np.uint8))
            ring.log(batches[-1])
            ring.publish()
        ring.status["late"][:] = (1, 1 << 63, 3, 4)
        ring.status["load"][...] = -0.5
        ring.set_state(State.RUNNING)
        lines = seen(program, ring.path)
        with RingReader("c", folder=tmp_path) as reader:
            check(lines, reader)


def check(lines: list[list[str]], reader: RingReader) -> None:
    said = {what: rest for what, rest in lines if what not in ("field", "get", "log")}
    assert [int(said[each]) for each in ("pid", "state", "generation", "heartbeat", "latest")] == [
        reader.pid,
        2,
        1,
        reader.heartbeat_ns,
        6,
    ]
    assert json.loads(said["description"]) == reader.description
    slot = reader.latest()
    for name, array in {**slot.arrays, **reader.status}.items():
        assert bytes.fromhex(said[name]) == array.tobytes()
    tables = [rest.split() for what, rest in lines if what == "field"]
    for (name, kind, dimensions, *shape), field in zip(
        tables, reader.slot_fields + reader.status_fields, strict=True
    ):
        assert Field(name, kind, tuple(map(int, shape[: int(dimensions)]))) == field
    gets = [int(rest) for what, rest in lines if what == "get"]
    assert gets == [-errno.ENODATA] * 2 + [0] * 4 + [-errno.ENODATA]
    data, lost = reader.log_reader(0).read()
    assert b"".join(bytes.fromhex(rest) for what, rest in lines if what == "log") == data
    assert (int(said["lost"]), int(said["position"])) == (lost, 6 * 777)
    assert lost > 0
    assert int(said["none"]) == -errno.ENOENT


def test_c_sees_nothing_torn_at_full_speed(program: Path) -> None:
    count = 20_000
    with own_name() as name:
        Ring.create(name, SLOT, slots=SLOTS, log_bytes=LOG_BYTES).close()
        with worker("write", name, count) as writer:
            command = [program, name, str(count)]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
                try:
                    assert process.stdout.readline() == "ready\n"
                    writer.communicate("go\n", timeout=120)
                    output = process.communicate(timeout=120)[0]
                finally:
                    process.kill()
    whole, torn, _, taken, lost, wrong = map(int, output.split())
    assert (torn, wrong) == (0, 0)
    assert whole > 0
    assert taken > 0
    sizes = sum(8 * (i % 64 + 1) for i in range(count))
    assert taken + lost >= sizes - 8 * 64  # but for the last, which comes after its slot


@pytest.mark.parametrize("damage", ["magic", "version", "size", "slots", "log", "cut", "table"])
def test_c_refuses_what_is_damaged(damage: str, program: Path, tmp_path: Path) -> None:
    with Ring.create("c", SLOT, folder=tmp_path) as ring:
        ring.log(bytes_of(b"x"))
        write(ring)
        data = bytearray(ring.path.read_bytes())
    at = {"magic": 3, "version": 8, "size": 18, "slots": 103, "log": 111, "table": 36}.get(damage)
    path = tmp_path / "damaged"
    if at is None:
        data = data[:5000]
    else:
        data[at] ^= 0x41
    path.write_bytes(data)
    assert seen(program, path) == [["refused", str(-errno.EPROTO)]]


def test_c_says_that_there_is_none(program: Path) -> None:
    assert seen(program, Path("no-such-ring")) == [["refused", str(-errno.ENOENT)]]


@pytest.mark.parametrize(
    ("compiler", "option"),
    [("cc", "-std=c99"), ("clang", "-std=c11"), ("c++", "-xc++")],
)
def test_headers_are_clean_for(compiler: str, option: str, tmp_path: Path) -> None:
    source = tmp_path / "one.c"
    headers = ("skinfield_ring_log.h", "skinfield_live.h")
    text = "".join(f"#include <{each}>\n" for each in headers)
    source.write_text(f"{text}int main(void) {{ return 0; }}\n")
    compiled(source, tmp_path, option, compiler=compiler)


def test_example_prints_each_new_slot(tmp_path: Path) -> None:
    program = compiled(EXAMPLE, tmp_path)
    with own_name() as name, Ring.create(name, [Field("force", "f8", (2,))]) as ring:
        ring.begin()["force"][:] = 1.25
        ring.publish()
        with subprocess.Popen([program, name, "force"], stdout=subprocess.PIPE, text=True) as found:
            try:
                assert found.stdout.readline() == "1 1.25\n"
                ring.begin()["force"][:] = -3
                ring.publish()
                assert found.stdout.readline() == "2 -3\n"
                ring.set_state(State.STOPPED)
                assert found.wait(60) == 0
            finally:
                found.kill()
        wrong = subprocess.run([program, name, "area"], capture_output=True, text=True, timeout=60)
        assert wrong.returncode == 1


def test_constants_are_those_of_python() -> None:
    text = (include_folder() / "skinfield_ring.h").read_text()
    found = dict(re.findall(r"SKINFIELD_RING_(\w+) = (\d+)", text))
    assert int(found.pop("VERSION")) == 1
    assert found == {state.name: str(int(state)) for state in State}


ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "ring.md").read_text(encoding="utf-8")


def snippet(language: str) -> str:
    (text,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return text


def test_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    with own_name() as name:
        exec(compile(snippet("python").replace('"demo"', repr(name)), "ring.md", "exec"), {})
    shown, log = capsys.readouterr().out.splitlines()
    assert shown == "1 [ 0.   0.  -1.5] {'unit': 'N'} RUNNING True"
    assert log == "16 bytes, 0 lost"


def test_c_is_the_example() -> None:  # which test_ring_c compiles and runs
    assert snippet("c") == (ROOT / "examples" / "c" / "ring_watch.c").read_text()

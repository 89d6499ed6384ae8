"""C headers of rings and of live skins against Python; programs and the page on the ring run."""

import errno
import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from live_skins import settings, skin_ring
from ring_scenes import LOG_BYTES, SLOT, SLOTS, bytes_of, compiled, own_name, worker, write
from test_readme import doc

from skinfield import loop
from skinfield.estimate.live_contacts import CONTACT
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop.ring_fields import VERSION
from skinfield.loop.slots import PATCH, CycleHead, CycleSlot
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import Field, Ring, RingReader, State, include_folder

HERE = Path(__file__).resolve().parent
WATCH, CONTACTS = (
    HERE.parent / "examples" / "c" / f"{name}.c" for name in ("ring_watch", "contacts")
)
HEADER = loop.include_folder() / "skinfield_live.h"
ROWS = (("skinfield_contact", CONTACT), ("skinfield_patch", PATCH))


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(HERE / "ring_reader.c", tmp_path_factory.mktemp("c"), "-std=c11")


def ran(program: Path, *words: object) -> "subprocess.CompletedProcess[str]":
    command = [str(program), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


def seen(program: Path, path: Path) -> list[list[str]]:
    return [line.split(" ", 1) for line in ran(program, path).stdout.splitlines()]


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
    numbers = [int(said[each]) for each in ("pid", "state", "generation", "heartbeat", "latest")]
    assert numbers == [reader.pid, 2, 1, reader.heartbeat_ns, 6]
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
    ("compiler", "option"), [("cc", "-std=c99"), ("clang", "-std=c11"), ("c++", "-xc++")]
)
def test_headers_are_clean_for(compiler: str, option: str, tmp_path: Path) -> None:
    source = tmp_path / "one.c"
    headers = ("skinfield_ring_log.h", "skinfield_live.h")
    text = "".join(f"#include <{each}>\n" for each in headers)
    source.write_text(f"{text}int main(void) {{ return 0; }}\n")
    compiled(source, tmp_path, option, compiler=compiler)


def test_example_prints_each_new_slot(tmp_path: Path) -> None:
    program = compiled(WATCH, tmp_path)
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
        assert ran(program, name, "area").returncode == 1


def test_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    page = doc("shared-memory")
    text = page.read_text(encoding="utf-8")
    (shown,) = re.findall(r"\{literalinclude\} (\S+\.c)$", text, re.MULTILINE)
    assert (page.parent / shown).resolve() == WATCH  # which is compiled and runs above
    (program,) = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    with own_name() as name, Ring.create(name, [Field("force", "f8")], [], {"unit": "N"}) as ring:
        ring.set_state(State.RUNNING)
        ring.begin()["force"][()] = -1.5
        ring.log(np.arange(16, dtype=np.uint8))
        ring.publish()
        found: dict[str, object] = {}
        exec(compile(program.replace('"skin"', repr(name)), page.name, "exec"), found)
        assert found["slot"]["force"] == -1.5  # type: ignore[index]
    assert capsys.readouterr().out == "1 RUNNING ['unit'] 16 0\n"


def test_rows_lie_as_in_python(tmp_path: Path) -> None:
    lines = []
    for struct, dtype in ROWS:
        lines.append(f'printf("{struct} %zu\\n", sizeof({struct}));')
        for name in dtype.names or ():
            part = f"(({struct} *)0)->{name}"
            lines.append(f'printf("%zu %zu\\n", offsetof({struct}, {name}), sizeof({part}));')
    source = tmp_path / "places.c"
    code = "\n".join(lines)
    source.write_text(f"#include <skinfield_live.h>\nint main(void) {{ {code} return 0; }}\n")
    wanted = []
    for struct, dtype in ROWS:
        wanted.append(f"{struct} {dtype.itemsize}")
        wanted += [f"{place} {part.itemsize}" for part, place in dtype.fields.values()]
    assert ran(compiled(source, tmp_path, "-std=c11")).stdout.splitlines() == wanted


def test_constants_are_those_of_python() -> None:
    text = (include_folder() / "skinfield_ring.h").read_text()
    found = dict(re.findall(r"SKINFIELD_RING_(\w+) = (\d+)", text))
    assert found == {each.name: str(int(each)) for each in State} | {"VERSION": "1"}
    text = HEADER.read_text()
    found = dict(re.findall(r"SKINFIELD_(\w+) = (\d+)", text))
    for prefix, names in (("HEAD_", CycleHead), ("", Answer), ("", CycleFlag)):
        assert [int(found[prefix + each.name]) for each in names] == list(map(int, names))
    assert (found["LIVE_VERSION"], found["HEAD_NUMBERS"]) == (str(VERSION), str(len(CycleHead)))
    assert f'\\"skinfield_live\\": {VERSION},' in text


def publish(ring: Ring, contacts: int, fresh: int = 1) -> CycleSlot:
    """A cycle with so many contacts, every number of which differs."""
    slot = CycleSlot.of(ring.begin())
    slot.head[:] = 0
    slot.head[CycleHead.FRESH], slot.head[CycleHead.CONTACTS] = fresh, contacts
    slot.patches["contacts"] = contacts
    rows = slot.contacts[0]
    for number, row in enumerate(rows):
        row["track"], row["patch"] = 10 * ring.number + number, 0
        row["position"] = np.array([1.25, -2.5, 0.5]) * 1e-3 * (number + 1)
        row["normal_force"], row["force_std"] = 0.125 + ring.number + number, 0.25
        row["peak_pressure"] = 1000.0 * (number + 2)
    ring.publish()
    return slot


def lines_of(number: int, slot: CycleSlot) -> list[str]:
    """What the example must print of a cycle."""
    return [
        f"cycle {number}  contact {row['track']}  patch {row['patch']}  at "
        + " ".join(f"{each * 1e3:.2f}" for each in row["position"])
        + f" mm  {row['normal_force']:.3f} +- {row['force_std']:.3f} N"
        + f"  {row['peak_pressure'] * 1e-3:.1f} kPa\n"
        for row in slot.used_contacts()
    ]


def test_the_example_prints_the_contacts_of_each_cycle(tmp_path: Path) -> None:
    program = compiled(CONTACTS, tmp_path, "-std=c11")
    with skin_ring() as ring:
        ring.set_state(State.RUNNING)
        wanted = lines_of(1, publish(ring, 2))
        with subprocess.Popen([program, ring.name], stdout=subprocess.PIPE, text=True) as found:
            try:
                assert [found.stdout.readline() for _ in wanted] == wanted
                publish(ring, 1, fresh=0)  # repeats an earlier answer: not told
                wanted = lines_of(3, publish(ring, 100))  # more than there are rows
                assert len(wanted) == 8
                assert [found.stdout.readline() for _ in wanted] == wanted
                ring.set_state(State.STOPPED)
                assert found.wait(60) == 0
            finally:
                found.kill()


def test_a_reader_without_room_learns_how_many_there_are(tmp_path: Path) -> None:
    source = tmp_path / "few.c"
    source.write_text(
        "#include <skinfield_live.h>\n"
        "int main(int count, char **words) {\n"
        "  skinfield_live live; skinfield_cycle cycle; skinfield_contact one[1];\n"
        "  skinfield_patch patch[1];\n"
        "  if (count < 2 || skinfield_live_open(&live, words[1])) return 1;\n"
        '  printf("%d\\n", skinfield_live_latest(&live, &cycle, one, 1, patch));\n'
        '  printf("%d\\n", (int)cycle.contacts);\n'
        '  printf("%d %g\\n", patch[0].contacts, one[0].normal_force);\n'
        '  printf("%d ", skinfield_live_runs(&live, 60.0));\n'
        '  printf("%d\\n", skinfield_live_runs(&live, -1.0));\n'
        "  return 0; }\n"
    )
    program = compiled(source, tmp_path)
    with skin_ring() as ring:
        assert ran(program, ring.name).stdout.splitlines()[0] == f"{-errno.ENODATA}"
        ring.set_state(State.RUNNING)
        slot = publish(ring, 5)
        force = slot.contacts[0, 0]["normal_force"]
        assert ran(program, ring.name).stdout.splitlines() == ["0", "5", f"5 {force:g}", "1 0"]


def test_rings_of_something_else_are_refused(tmp_path: Path) -> None:
    program = compiled(CONTACTS, tmp_path)
    with Ring.create(settings().name, [Field("x", "<f8", (1,))], folder=tmp_path) as ring:
        for name, why in ((str(ring.path), "Protocol error"), ("no-such-skin", "No such file")):
            found = ran(program, name)
            assert found.returncode == 1
            assert why in found.stderr

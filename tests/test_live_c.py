"""The C header of live skins against the arrays of Python, by programs that are compiled here."""

import errno
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from live_skins import settings, skin_ring
from ring_scenes import compiled

from skinfield.estimate.live_contacts import CONTACT
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop import include_folder
from skinfield.loop.ring_fields import VERSION
from skinfield.loop.slots import PATCH, Head, Slot
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import Field, Ring, State

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
EXAMPLE = Path(__file__).resolve().parent.parent / "examples" / "c" / "contacts.c"
HEADER = include_folder() / "skinfield_live.h"
ROWS = (("skinfield_contact", CONTACT), ("skinfield_patch", PATCH))


def said(program: Path, *words: str) -> list[str]:
    found = subprocess.run([program, *words], capture_output=True, text=True, timeout=60)
    return found.stdout.splitlines()


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
        assert dtype.fields is not None
        wanted.append(f"{struct} {dtype.itemsize}")
        wanted += [f"{place} {part.itemsize}" for part, place in dtype.fields.values()]
    assert said(compiled(source, tmp_path, "-std=c11")) == wanted


@pytest.mark.parametrize(("prefix", "names"), [("HEAD_", Head), ("", Answer), ("", CycleFlag)])
def test_constants_are_those_of_python(prefix: str, names: type) -> None:
    found = dict(re.findall(r"SKINFIELD_(\w+) = (\d+)", HEADER.read_text()))
    for each in names:
        assert int(found[prefix + each.name]) == int(each)


def test_versions_agree() -> None:
    text = HEADER.read_text()
    assert f"SKINFIELD_LIVE_VERSION = {VERSION} " in text
    assert f'\\"skinfield_live\\": {VERSION},' in text
    assert f"SKINFIELD_HEAD_NUMBERS = {len(Head)}\n" in text


def publish(ring: Ring, contacts: int, fresh: int = 1) -> Slot:
    """A cycle with so many contacts, every number of which differs."""
    slot = Slot.of(ring.begin())
    slot.head[:] = 0
    slot.head[Head.FRESH], slot.head[Head.CONTACTS] = fresh, contacts
    slot.patches["contacts"] = contacts
    rows = slot.contacts[0]
    for number, row in enumerate(rows):
        row["track"], row["patch"] = 10 * ring.number + number, 0
        row["position"] = np.array([1.25, -2.5, 0.5]) * 1e-3 * (number + 1)
        row["normal_force"], row["force_std"] = 0.125 + ring.number + number, 0.25
        row["peak_pressure"] = 1000.0 * (number + 2)
    ring.publish()
    return slot


def lines_of(number: int, slot: Slot) -> list[str]:
    """What the example must print of a cycle."""
    return [
        f"cycle {number}  contact {row['track']}  patch {row['patch']}  at "
        + " ".join(f"{each * 1e3:.2f}" for each in row["position"])
        + f" mm  {row['normal_force']:.3f} +- {row['force_std']:.3f} N"
        + f"  {row['peak_pressure'] * 1e-3:.1f} kPa\n"
        for row in slot.used_contacts()
    ]


def test_the_example_prints_the_contacts_of_each_cycle(tmp_path: Path) -> None:
    program = compiled(EXAMPLE, tmp_path, "-std=c11")
    with skin_ring() as ring:
        ring.set_state(State.RUNNING)
        wanted = lines_of(1, publish(ring, 2))
        with subprocess.Popen([program, ring.name], stdout=subprocess.PIPE, text=True) as found:
            assert found.stdout is not None
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
        assert said(program, ring.name)[0] == f"{-errno.ENODATA}"
        ring.set_state(State.RUNNING)
        slot = publish(ring, 5)
        force = slot.contacts[0, 0]["normal_force"]
        assert said(program, ring.name) == ["0", "5", f"5 {force:g}", "1 0"]


def test_rings_of_something_else_are_refused(tmp_path: Path) -> None:
    program = compiled(EXAMPLE, tmp_path)
    with Ring.create(settings().name, [Field("x", "<f8", (1,))], folder=tmp_path) as ring:
        for name, why in ((str(ring.path), "Protocol error"), ("no-such-skin", "No such file")):
            found = subprocess.run([program, name], capture_output=True, text=True, timeout=60)
            assert found.returncode == 1
            assert why in found.stderr

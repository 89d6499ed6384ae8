import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from virtual_host import QUIET

from skinfield.virtual import VirtualSettings, VirtualSkin
from skinfield.virtual.commands import commands_of
from skinfield.virtual.control import ANSWER, answer_to, encoded

PLAIN = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=12)
VALUE = (
    PLAIN | st.lists(PLAIN, max_size=4) | st.dictionaries(st.text(max_size=4), PLAIN, max_size=2)
)
KEYS = (
    "id patch x y taxel face weights force radius shape fault kind what after seconds lose swap "
    "duplicate scene tag"
)
WORDS = ["press", "move", "release", "fault", "clear", "wires", "scene", "truth", "nothing"]
COMMAND = st.dictionaries(st.sampled_from(KEYS.split()), VALUE, max_size=7)


@pytest.fixture(scope="module")
def skin():
    made = VirtualSkin(VirtualSettings(**QUIET, control="", at_once=True))
    made.world._solving.start = lambda *_: None  # nothing is solved beside
    yield made
    made.close()


@settings(max_examples=300)
@given(what=st.sampled_from(WORDS), command=COMMAND)
def test_any_command_is_answered_and_the_skin_goes_on(skin, what, command):
    data = json.dumps({"do": what, **command}).encode()
    answer = answer_to(data, commands_of(skin))
    said = json.loads(encoded(answer))
    assert said["ok"] or "expected" in said["error"] or len(said["error"]) == 2000
    skin.step(skin.started_ns + 10**9 * (1 + len(data)))
    counts = skin.hardware.converters.counts
    assert ((counts >= 0) & (counts <= 65535)).all()


@settings(max_examples=200)
@given(data=st.binary(max_size=200) | st.text(max_size=100).map(str.encode))
def test_any_bytes_are_answered(skin, data):
    assert answer_to(data, commands_of(skin))["ok"] is False


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"x" * 5000, "command has 5000 bytes, expected at most 4096"),
        (b"[" * 4000, "command is no"),
        (b"[1]", "command is no plain object"),
        (b'{"do": 1}', "do is 1, expected one of clear, counts"),
        (b'{"do": "press"}', "x is None, expected a number"),
        (b'{"do": "press", "x": 0, "y": 1e999}', "y is inf"),
        (b'{"do": "press", "taxel": 0, "shape": "star"}', "shape is 'star'"),
        (b'{"do": "press", "taxel": 0, "radius": 4}', "radius is 4"),
        (b'{"do": "press", "face": 0, "weights": [0, 0, 0]}', "weights is [0, 0, 0]"),
        (b'{"do": "press", "taxel": 0, "patch": "palm"}', "patch 'palm' is not in"),
        (b'{"do": "wires", "lose": 2}', "lose is 2"),
    ],
)
def test_what_is_wrong_is_said(skin, data, said):
    answer = answer_to(data, commands_of(skin))
    assert answer["ok"] is False
    assert said in answer["error"]


def test_a_face_is_a_place(skin):
    commands = commands_of(skin)
    patch = skin.skin.patches[0]
    said = answer_to(b'{"do": "press", "face": 5, "weights": [1, 1, 2], "tag": 9}', commands)
    corners = patch.plane[patch.triangles[5]]
    assert said["ok"]
    assert said["tag"] == 9
    assert (said["x"], said["y"]) == pytest.approx(tuple([0.25, 0.25, 0.5] @ corners))
    answer_to(b'{"do": "release"}', commands)


def test_an_answer_is_one_datagram(skin):
    long = encoded({"ok": True, "lines": "x" * 70_000, "tag": 3})
    assert len(long) < ANSWER
    assert json.loads(long) == {
        "ok": False, "error": "the answer has 70035 bytes: ask for less at once", "tag": 3,
    }  # fmt: skip
    for number in range(64):
        skin.world.press({"taxel": number, "id": f"{number:064d}"})
    for step in range(300):
        for number in range(64):
            skin.world.move({"id": f"{number:064d}", "x": 1e-4 * step, "y": 0.0})
        skin.truth.note([(t, 1e-3) for t in skin.world.touches(-1.0)], 10**9 * step)
    said = answer_to(b'{"do": "truth", "after": 0}', commands_of(skin))
    assert len(encoded(said)) < ANSWER
    assert said["lines"][0]["number"] == 0
    skin.world.release({})

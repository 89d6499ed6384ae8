"""One tree of settings: the same from TOML, the command line and JSON; what is wrong is named."""

import json
from contextlib import suppress
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import pytest
from command_line import invoke
from hypothesis import given, settings
from hypothesis import strategies as st

from skinfield.cli.options import flag_of
from skinfield.cli.profiles import PROFILES, load_profile, profile_of
from skinfield.cli.settings import (
    Settings,
    SkinSettings,
    changed,
    load_settings,
    settings_from_toml,
    toml_from_settings,
)
from skinfield.errors import FileError, InputError
from skinfield.files.layouts.load import layout_format
from skinfield.page.settings import PageSettings
from skinfield.settings import Positive, Range, SettingError, json_from_value, value_from_json

TEXT = st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=12)
WORDS = {  # fields whose values are checked in their own way
    "layout": TEXT,
    "urdf": st.none(),  # it takes parts
    "options": st.just(("period_ms=20", "config=a b.xml")),
    "ros_rate": st.just(()),
    "ros_domain": st.none(),
    "robot": st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True),
    "host": st.sampled_from(["127.0.0.1", "::1"]),
    "zenoh_listen": st.just(()),
    "zenoh_connect": st.just(()),
    "zenoh_config": st.none(),
    "yarp_name_server": st.none(),
    "rate_hz": st.floats(1.0, 1e5),
    "gain": st.none() | st.floats(-1e4, -1e-3),
    "keep": st.none() | st.sampled_from(["3", "0-5,17"]),
    "without": st.none() | st.sampled_from(["6", "7-9"]),
    "deadline_us": st.none() | st.floats(0.1, 9.0),
}


def values_of(hint: Any) -> st.SearchStrategy[Any]:
    """Values of a field that its checks let pass."""
    check = None
    if get_origin(hint) is Annotated:
        hint, *more = get_args(hint)
        check = next((each for each in more if isinstance(each, Positive | Range)), None)
    if type(None) in get_args(hint):
        inner = next(each for each in get_args(hint) if each is not type(None))
        return st.none() | values_of(Annotated[inner, check] if check else inner)
    low, high = (check.low, check.high) if isinstance(check, Range) else (1e-6, 1e9)
    if get_origin(hint) is Literal:
        return st.sampled_from(get_args(hint))
    kinds = {
        bool: st.booleans(),
        int: st.integers(int(low), int(min(high, 1 << 62))),
        float: st.floats(low, high),
        str: TEXT,
        tuple[str, ...]: st.lists(TEXT, max_size=3).map(tuple),
    }
    return kinds[hint]


@st.composite
def trees(draw: Any) -> Settings:
    """Any settings."""
    tree = Settings()
    for section in fields(Settings):
        part = getattr(tree, section.name)
        hints = get_type_hints(type(part), include_extras=True)
        chosen = draw(st.sets(st.sampled_from(sorted(hints)), max_size=4))
        values = {
            name: draw(WORDS[name] if name in WORDS else values_of(hints[name]))
            for name in sorted(chosen)
        }
        tree = replace(tree, **{section.name: replace(part, **values)})
    return tree


def words_of(tree: Settings) -> list[str]:
    """Flags that say the same."""
    words = []
    for values in changed(tree).values():
        for name, value in values.items():
            flag = flag_of(name)
            if isinstance(value, bool):
                words.append(f"--{flag}" if value else f"--no-{flag}")
            else:
                each = value if isinstance(value, list) else [value]
                words += [f"--{flag}={one}" for one in each]
    return words


@settings(max_examples=12, deadline=None)
@given(trees())
def test_toml_flags_and_json_say_the_same(tmp_path_factory: Any, tree: Settings) -> None:
    text = toml_from_settings(tree)
    assert settings_from_toml(text) == tree
    text_of_json = json_from_value(tree)
    assert value_from_json(Settings, text_of_json) == tree
    assert json.loads(text_of_json)["loop"]["rate_hz"] == tree.loop.rate_hz
    file = tmp_path_factory.mktemp("settings") / "saved.toml"
    done = invoke(["run", *words_of(tree), "--save", str(file)])
    assert done.exit_code == 0, done.output
    assert load_settings(file) == tree
    assert file.read_text() == text
    again = file.with_stem("again")
    assert invoke(["run", str(file), "--save", str(again)]).exit_code == 0
    assert again.read_text() == text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[loop]\n\nrate_hz = -1", "a.toml:3: [loop] rate_hz is -1.0, expected a finite number"),
        ("[loop]\nrate_hz = 'x'", "a.toml:2: [loop] rate_hz is 'x', expected a number"),
        ("[loop]\nrate = 3", "a.toml:2: [loop] 'rate' is not known, expected one of name, rate_hz"),
        ("[loop]\nrate = 3", "(did you mean rate_hz?)"),
        ("[lop]", "a.toml:1: 'lop' is not known, expected one of skin, source, model, loop, page"),
        ("loop = 3", "a.toml:1: loop is 3, expected a table"),
        ("[model]\nsolver = 'nonegative'", "expected one of auto, gaussian, nonnegative"),
        ("[model]\nsolver = 'nonegative'", "(did you mean nonnegative?)"),
        ("[source]\nchannel = [3]", "a.toml:2: [source] channel[0] is 3, expected a text in q"),
        ("[source]\noptions = ['x']", "[source] options is 'x', expected KEY=VALUE"),
        ("[page]\nhost = '0.0.0.0'", "a.toml:2: [page] host is '0.0.0.0', which others can reach"),
        ("[loop]\nevents = 1", "a.toml:2: [loop] events is 1, expected true or false"),
        ("[loop]\ndeadline_us = 2e3", "expected less than the period of 1000 µs"),
        ("[bridges]\nros_domain = 3", "[bridges] ros_domain was given, expected ros2 with it"),
        ("x =", "a.toml is not TOML: "),
    ],
)
def test_what_is_wrong_in_a_file_is_named(text: str, message: str) -> None:
    with pytest.raises(FileError) as caught:
        settings_from_toml(text, "a.toml")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "text", ["", "[", "[]", "null", '{"loop": 1}', '{"loop": {"rate_hz": ""}}']
)
def test_json_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        value_from_json(Settings, text)


@given(st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
def test_any_bytes_are_settings_or_an_error(data: bytes) -> None:
    for read in (
        lambda: settings_from_toml(data.decode(errors="replace")),
        lambda: value_from_json(Settings, data),
    ):
        with suppress(InputError):
            assert isinstance(read(), Settings)


def test_a_page_for_others_needs_a_token() -> None:
    for host in ("0.0.0.0", "192.168.1.2", "robot.local", "::"):
        with pytest.raises(SettingError, match="expected 8 or more"):
            PageSettings(host=host, token="short")
    assert PageSettings(host="localhost") == PageSettings(host="127.0.0.1")


def test_profiles_are_whole_and_go_by_boards_and_layout(tmp_path: Path) -> None:
    for name in PROFILES:
        profile = load_profile(name)
        assert profile.name == name
        assert set(profile.assumed) <= {"thickness_mm", "modulus_kpa", "poisson"}
        assert f"profile {name}: 2 mm" in profile.sentence(SkinSettings())
    mine = tmp_path / "mine.toml"
    mine.write_text('name = "mine"\nthickness_mm = 3\nmodulus_kpa = 80\npoisson = 0.45\ngain = -90')
    given = SkinSettings(profile=str(mine), modulus_kpa=95.0)
    sentence = profile_of(given).sentence(given)
    assert sentence == "profile mine: 3 mm, 95 kPa as given, ν 0.45, gain -90"
    layout = tmp_path / "somewhere.toml"
    for hardware, text, name in (
        ("icub", str(layout), "icub"), ("yarp", str(layout), "icub"), ("shm", "", "cyskin"),
        ("icub", "hexagon72", "silicone-2mm"), (None, "cylinder:radius_mm=40", "silicone-2mm"),
        (None, str(layout), "generic"), ("packet", str(layout), "generic"),
    ):  # fmt: skip
        assert profile_of(SkinSettings(), hardware, layout_format(text)).name == name
    foot = tmp_path / "foot.txt"
    foot.write_text("[calibration]\n0.01 0 0 0 0 1\n")
    assert profile_of(SkinSettings(), None, layout_format(str(foot))).name == "icub"


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("icubb", None, "expected one of generic, icub, cyskin, silicone-2mm, or a file"),
        ("nowhere.toml", None, "nowhere.toml cannot be read"),
        ("p.toml", "name = 'p'", "thickness_mm is missing, expected"),
        ("p.toml", "name = 'p'\nthickness_mm = 0\nmodulus_kpa = 9\npoisson = 0",
         "thickness_mm is 0.0, expected"),
        ("p.toml", "thicknes_mm = 2", "did you mean thickness_mm"),
    ],
)  # fmt: skip
def test_profiles_that_cannot_be_used(
    name: str, text: str | None, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if text is not None:
        Path(name).write_text(text)
    with pytest.raises(InputError) as caught:
        load_profile(name)
    assert message in str(caught.value)

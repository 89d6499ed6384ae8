"""Garbage in place of robots' XML: refused with a reason, never a crash, never a full memory."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from icub_files import OLD_SKIN, SKIN, SPEC, WRAPPER

from skinfield.errors import FileError
from skinfield.protocols.icub import command_from, load_configuration
from skinfield.protocols.icub.xml_tree import LARGEST, tree_of, without_comments

LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE lolz [
 <!ENTITY lol "lol">
 <!ENTITY lol1 "&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;">
]>
<device>&lol1;</device>
"""


@pytest.mark.parametrize(
    ("data", "error"),
    [
        (LAUGHS, "some-skin.xml:3: declares the entity 'lol', expected none"),
        (
            '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><device>&x;</device>',
            "declares the entity 'x'",
        ),
        (
            '<!DOCTYPE a [<!ENTITY % x SYSTEM "file:///etc/passwd"> %x;]><device/>',
            "declares the entity 'x'",
        ),
        ("<a>" * 40, "more than 32 elements within each other"),
        (b"<a>" + b" " * LARGEST + b"</a>", "larger than 1048576 bytes"),
        ("", "no element found"),
        ("<!-- only -->", "no element found"),
        (b"\x00\xff\xfe", "some-skin.xml:1: .*expected well-formed XML"),
        ('<?xml version="1.0" encoding="no-such"?><a/>', "unknown encoding"),
        ("<!--" * 200000, "expected well-formed XML"),
    ],
)
def test_what_is_no_robot_s_file(tmp_path, data, error):
    path = tmp_path / "some-skin.xml"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(FileError, match=error):
        load_configuration(path)


def test_comments_keep_their_lines():
    assert without_comments(b"a<!-- \n <!-- -- \n -->b<!---->c<!-- d") == b"a\n\nbc<!-- d"
    assert tree_of(b"<a><!-- \n\n --><b/></a>", "x").children[0].line == 3


PIECES = st.lists(
    st.one_of(
        st.sampled_from([SKIN, SPEC, WRAPPER, OLD_SKIN, LAUGHS]),
        st.sampled_from(
            ["<!--", "-->", "<group name='patches'>", "</group>", " 0x ", "\0", "&amp;"]
        ),
        st.text(max_size=6),
    ),
    max_size=4,
)


@given(st.sampled_from([SKIN, SPEC, WRAPPER, OLD_SKIN]), PIECES, st.data())
def test_any_file_is_read_or_refused(tmp_path_factory, text, pieces, data):
    for piece in pieces:
        at = data.draw(st.integers(0, len(text)))
        stop = data.draw(st.integers(at, min(len(text), at + 20)))
        text = text[:at] + piece + text[stop:]
    path = tmp_path_factory.getbasetemp() / "any.xml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        found = load_configuration(path)
    except FileError:
        return
    assert all(command_from(data) for _, data in found.messages())

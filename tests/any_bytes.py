"""Damaged copies of whole files, and bytes that were never one, for tests of what reads files."""

from typing import Any

from hypothesis import strategies as st

ODD = [b"", b"\0", b"\n", b" ", b",", b"(", b"#", b".", b"-", b"nan", b"-1", b"1e999", b"1e300",
       b"-1e-300", b"99" * 15, b"0x10", b"[[", b"{}", b"null", b'"a"', b"\xff"]  # fmt: skip
PIECES = st.sampled_from(ODD) | st.binary(max_size=6)
ANYTHING = st.binary(max_size=300) | st.text(max_size=200).map(str.encode)


@st.composite
def damaged(draw: Any, whole: bytes) -> bytes:
    """A file of which some bytes or words were taken out or exchanged, and that may be cut off."""
    between = draw(st.sampled_from([b"", b" "]))
    parts = whole.split(between) if between else [bytes([octet]) for octet in whole]
    for _ in range(draw(st.integers(0, 6))):
        start = draw(st.integers(0, len(parts)))
        parts[start : start + draw(st.integers(0, 9))] = [draw(PIECES)]
    found = between.join(parts)
    return found[: draw(st.just(len(found)) | st.integers(0, len(found)))]

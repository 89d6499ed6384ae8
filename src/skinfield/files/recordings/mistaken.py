"""Diagnosis of files that are no recordings, for the error message."""

import re

from skinfield.files.recordings.head import Head, is_whole
from skinfield.files.recordings.table import looks_like_numbers

LAYOUT = "a layout (where the taxels are), not a recording: give it as the layout"
BINARY = {
    b"# .PCD": f"a PCD point cloud: {LAYOUT}",
    b"\x1f\x8b": "compressed by gzip: unpack it first",
    b"BZh": "compressed by bzip2: unpack it first",
    b"\xfd7zXZ": "compressed by xz: unpack it first",
    b"\x93NUMPY": "one NumPy array without times: save it as NPZ with stamp_ns and counts",
    b"PAR1": "a Parquet table: save it as CSV with a column time_s",
    b"\x89HDF": "an HDF5 or MATLAB file: save it as NPZ or CSV",
    b"MATLAB 5.0": "a MATLAB file: save it as NPZ or CSV",
    b"\x89PNG": "a picture",
    b"\xff\xd8\xff": "a picture",
    b"%PDF": "a PDF document",
    b"\xff\xfe": "UTF-16 text: save it as UTF-8",
    b"\xfe\xff": "UTF-16 text: save it as UTF-8",
}
TEXT = {
    r"^\s*(taxel2Repr|spatial_sampling|\[calibration\])": f"iCub taxel positions: {LAYOUT}",
    r"^VERSION [.\d]+\s*\nFIELDS ": f"a PCD point cloud: {LAYOUT}",
    r"^\s*\[SENSORS\]": f"a skinGui file: {LAYOUT}",
    r'\A\s*[{\[][\s\S]*"(taxels|tactile_maps|parent_frames)"': f"robotskinlib JSON: {LAYOUT}",
    r"\A\s*[{\[]\s*[\"{\[\]}]": "JSON",
    r"\A(\s*#.*\n|\s*\n)*\s*(\[\[?[-\w.]+\]\]?\s*$|\w+\s*=)": f"TOML or INI, most likely {LAYOUT}",
    r"\A\s*\d+\s+\d+\s*\n(\s*-?\d+\.\d+){8}": f"a Skinware calibration cache: {LAYOUT}",
    r"\A\s*\d+\s*\n\s*\d+(\s+-?\d+){10}\s*\n": f"a Skinware skin.calib: {LAYOUT}",
    r"\A(Type|Stamp|Source): ": "the info.log of a yarpdatadumper log: give the data.log beside it",
    r"\A\[\d+\.\d+\] /": "the info.log of a yarpdatadumper log: give the data.log beside it",
    r"\A\s*<": "XML or HTML",
}
KNOWN = (
    "a recording: a yarpdatadumper log (sequence time values), CySkin text (a line of uids, then "
    "sample time values), CySkin SkinRecorder text (devices, taxels, then sample time n uid value "
    "...), CSV with a line of names (time_s,taxel_0,...), or NPZ (stamp_ns, counts)"
)


def verdict(head: Head) -> str:
    """One sentence on what the file is, naming file and line, and what was expected."""
    for start, what in BINARY.items():
        if head.data.startswith(start):
            return f"{head.path} is {what}; expected {KNOWN}"
    if is_binary(head):
        return f"{head.path} is a binary file; expected {KNOWN}"
    text = "\n".join(head.lines[:2000])
    for pattern, what in TEXT.items():
        if re.search(pattern, text[:100_000], re.MULTILINE):
            return f"{head.path} is {what}; expected {KNOWN}"
    if not head.numbered():
        return f"{head.path} holds comments alone; expected {KNOWN}"
    number, line = head.numbered()[0]
    tokens = line.split()
    if len(tokens) > 1 and all(map(is_whole, tokens)):
        why = f"starts with {len(tokens)} whole numbers, but no lines of {len(tokens) + 2} follow"
    elif looks_like_numbers(head):
        why = "holds numbers, but no line of names stands above them"
    elif re.search("[,;\t]", line):
        why = f"its names {shortened(line)!r} hold neither time_s nor stamp_ns"
    else:
        why = f"{shortened(line)!r} is no line of a known recording"
    return f"{head.path}:{number}: {why}; expected {KNOWN}"


def shortened(text: str, length: int = 60) -> str:
    """The text, or its beginning with dots."""
    return text if len(text) <= length else text[:length] + "..."


def is_binary(head: Head) -> bool:
    """Whether control characters are there that no text has."""
    sample = head.data[:65536]
    control = sum(sample.count(bytes([byte])) for byte in (*range(9), *range(14, 32), 127))
    return b"\0" in sample or control * 50 > len(sample)

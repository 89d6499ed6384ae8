"""Recordings of a live skin (`skinfield record`, MCAP) as counts over time, as other formats are.

What else such a file holds, `LiveRecording` reads.
"""

from collections.abc import Sequence
from dataclasses import replace

from skinfield.reading import Recording
from skinfield.sources.recordings.columns import chosen
from skinfield.sources.recordings.head import Head
from skinfield.sources.recordings.lines import Progress
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.sources.recordings.mcap_records import MAGIC
from skinfield.sources.recordings.mcap_table import LiveStream as LiveStream
from skinfield.sources.recordings.mcap_table import collected_live, stream_of


def matches(head: Head) -> bool:
    """Whether the file is an MCAP file."""
    return head.data.startswith(MAGIC)


def stream(
    head: Head, columns: Sequence[int | str] | None, progress: Progress | None
) -> LiveStream:
    """Open a file whose head `matches`, to be read piece by piece."""
    found = stream_of(LiveRecording.open(head.path), progress=progress)
    if columns is None:
        return found
    keep = chosen(columns, found.like.counts.shape[1], head.path)
    uid = found.like.uid
    like = replace(
        found.like, counts=found.like.counts[:, keep], uid=None if uid is None else uid[keep]
    )
    return replace(found, like=like, channel=found.channel[keep])


def read(head: Head, columns: Sequence[int | str] | None, progress: Progress | None) -> Recording:
    """Read a file whose head `matches`, as a whole."""
    return collected_live(stream(head, columns, progress))

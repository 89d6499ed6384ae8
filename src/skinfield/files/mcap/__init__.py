"""MCAP: recordings of a live skin, read and written."""

from skinfield.files.mcap.writer import RecordingWriter as RecordingWriter
from skinfield.files.mcap.writer import enclosures as enclosures

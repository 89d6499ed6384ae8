"""Where readings come from: the edge of the package."""

from skinfield.sources.recordings import LiveRecording as LiveRecording
from skinfield.sources.recordings import open_recording as open_recording
from skinfield.sources.recordings import readings_for as readings_for
from skinfield.sources.recordings import stream_recording as stream_recording
from skinfield.sources.results import load_contacts as load_contacts
from skinfield.sources.results import open_results as open_results

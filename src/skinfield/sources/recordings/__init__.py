"""Recordings of skins, and of force sensors beside them: one file per format."""

from skinfield.sources.recordings.matching import readings_for as readings_for
from skinfield.sources.recordings.mcap_live import LiveRecording as LiveRecording
from skinfield.sources.recordings.open import open_recording as open_recording
from skinfield.sources.recordings.open import stream_recording as stream_recording
from skinfield.sources.recordings.stream import RecordingStream as RecordingStream

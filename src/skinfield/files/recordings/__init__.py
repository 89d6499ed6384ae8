"""Recordings of skins, and of force sensors beside them: one file per format."""

from skinfield.files.recordings.lines import RecordingStream as RecordingStream
from skinfield.files.recordings.matching import readings_for as readings_for
from skinfield.files.recordings.open import open_recording as open_recording
from skinfield.files.recordings.replay import ReplaySource as ReplaySource

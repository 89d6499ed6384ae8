"""Recordings of a live skin as MCAP files."""

from skinfield.sinks.mcap.views import FoxgloveViews as FoxgloveViews
from skinfield.sinks.mcap.views import RosViews as RosViews
from skinfield.sinks.mcap.views import Views as Views
from skinfield.sinks.mcap.writer import RecordingSettings as RecordingSettings
from skinfield.sinks.mcap.writer import RecordingWriter as RecordingWriter
from skinfield.sinks.mcap.writer import enclosures as enclosures

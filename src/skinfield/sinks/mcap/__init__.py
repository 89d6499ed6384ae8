"""Recordings of a live skin as MCAP files."""

from skinfield.sinks.mcap.compression import Compression as Compression
from skinfield.sinks.mcap.compression import Lz4 as Lz4
from skinfield.sinks.mcap.compression import NoCompression as NoCompression
from skinfield.sinks.mcap.compression import Zstd as Zstd
from skinfield.sinks.mcap.enclosures import enclosures as enclosures
from skinfield.sinks.mcap.views import Views as Views
from skinfield.sinks.mcap.views_foxglove import FoxgloveViews as FoxgloveViews
from skinfield.sinks.mcap.views_ros import RosViews as RosViews
from skinfield.sinks.mcap.writer import RecordingSettings as RecordingSettings
from skinfield.sinks.mcap.writer import RecordingWriter as RecordingWriter

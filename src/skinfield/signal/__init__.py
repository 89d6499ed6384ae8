"""Readings: bytes of a source to counts, and counts to pF, ΔC/C₀, gap and stress, and back."""

from skinfield.signal.baseline import Baseline as Baseline
from skinfield.signal.baseline import estimate_baseline as estimate_baseline
from skinfield.signal.block import Block as Block
from skinfield.signal.block import Kind as Kind
from skinfield.signal.block import Status as Status
from skinfield.signal.block import blocks_of as blocks_of
from skinfield.signal.blocks import Blocks as Blocks
from skinfield.signal.blocks import Channels as Channels
from skinfield.signal.boards import Convention as Convention
from skinfield.signal.boards import CySkinCount as CySkinCount
from skinfield.signal.boards import ICubByte as ICubByte
from skinfield.signal.boards import PlainCount as PlainCount
from skinfield.signal.boards import valid_from_counts as valid_from_counts
from skinfield.signal.calibration import Calibration as Calibration
from skinfield.signal.calibration import load_calibration as load_calibration
from skinfield.signal.calibration import save_calibration as save_calibration
from skinfield.signal.calibration import (
    strain_from_relative_capacitance as strain_from_relative_capacitance,
)
from skinfield.signal.fault_evidence import Verdict as Verdict
from skinfield.signal.faults import Faults as Faults
from skinfield.signal.faults import find_faults as find_faults
from skinfield.signal.filters import Exponential as Exponential
from skinfield.signal.filters import Filter as Filter
from skinfield.signal.filters import NoFilter as NoFilter
from skinfield.signal.filters import filtered as filtered
from skinfield.signal.scale import column_of as column_of
from skinfield.signal.scale import fit_scale as fit_scale
from skinfield.signal.source import Count as Count
from skinfield.signal.source import Lasting as Lasting
from skinfield.signal.source import Port as Port
from skinfield.signal.source import Retry as Retry
from skinfield.signal.source import Source as Source
from skinfield.signal.source import Stream as Stream
from skinfield.signal.source import counters as counters
from skinfield.signal.stationary import quiet_stretch as quiet_stretch

"""Counts to pF, ΔC/C₀, gap and stress, and back; baselines, faults and filters of taxels."""

from skinfield.conditioning.baseline import Baseline as Baseline
from skinfield.conditioning.baseline import estimate_baseline as estimate_baseline
from skinfield.conditioning.boards import Convention as Convention
from skinfield.conditioning.boards import CySkinCount as CySkinCount
from skinfield.conditioning.boards import ICubByte as ICubByte
from skinfield.conditioning.boards import PlainCount as PlainCount
from skinfield.conditioning.boards import valid_from_counts as valid_from_counts
from skinfield.conditioning.calibration import Calibration as Calibration
from skinfield.conditioning.calibration import load_calibration as load_calibration
from skinfield.conditioning.calibration import save_calibration as save_calibration
from skinfield.conditioning.capacitance import VACUUM_PERMITTIVITY as VACUUM_PERMITTIVITY
from skinfield.conditioning.capacitance import CapacitanceConverter as CapacitanceConverter
from skinfield.conditioning.capacitance import (
    capacitance_change_from_gap as capacitance_change_from_gap,
)
from skinfield.conditioning.capacitance import capacitance_from_gap as capacitance_from_gap
from skinfield.conditioning.capacitance import gap_from_capacitance as gap_from_capacitance
from skinfield.conditioning.capacitance import (
    gap_from_capacitance_change as gap_from_capacitance_change,
)
from skinfield.conditioning.capacitance import pad_area as pad_area
from skinfield.conditioning.capacitance import (
    relative_capacitance_from_strain as relative_capacitance_from_strain,
)
from skinfield.conditioning.capacitance import rest_capacitance as rest_capacitance
from skinfield.conditioning.capacitance import (
    strain_from_relative_capacitance as strain_from_relative_capacitance,
)
from skinfield.conditioning.faults import FaultLimits as FaultLimits
from skinfield.conditioning.faults import Faults as Faults
from skinfield.conditioning.faults import Verdict as Verdict
from skinfield.conditioning.faults import find_faults as find_faults
from skinfield.conditioning.filters import Chain as Chain
from skinfield.conditioning.filters import ConstantVelocity as ConstantVelocity
from skinfield.conditioning.filters import Exponential as Exponential
from skinfield.conditioning.filters import Filter as Filter
from skinfield.conditioning.filters import FilterState as FilterState
from skinfield.conditioning.filters import MovingMedian as MovingMedian
from skinfield.conditioning.filters import NoFilter as NoFilter
from skinfield.conditioning.filters import RandomWalk as RandomWalk
from skinfield.conditioning.filters import filtered as filtered
from skinfield.conditioning.filters import rise_time as rise_time
from skinfield.conditioning.filters import step_response as step_response
from skinfield.conditioning.stationary import QuietStretch as QuietStretch
from skinfield.conditioning.stationary import quiet_stretch as quiet_stretch
from skinfield.conditioning.tensile_test import LinearCurve as LinearCurve
from skinfield.conditioning.tensile_test import ModulusFit as ModulusFit
from skinfield.conditioning.tensile_test import StressCurve as StressCurve
from skinfield.conditioning.tensile_test import TableCurve as TableCurve
from skinfield.conditioning.tensile_test import TensileTest as TensileTest
from skinfield.conditioning.tensile_test import curve_from_tension as curve_from_tension
from skinfield.conditioning.tensile_test import initial_modulus as initial_modulus
from skinfield.conditioning.tensile_test import load_tensile_test as load_tensile_test

"""Calibration of taxels from recordings in which what presses them is known."""

from skinfield.calibrate.by_force import ForceCalibration as ForceCalibration
from skinfield.calibrate.by_force import force as force
from skinfield.calibrate.by_pressure import PressureCalibration as PressureCalibration
from skinfield.calibrate.by_pressure import pressure as pressure
from skinfield.calibrate.by_touch import TouchCalibration as TouchCalibration
from skinfield.calibrate.by_touch import touch as touch
from skinfield.calibrate.file import load_calibration as load_calibration
from skinfield.calibrate.file import save_calibration as save_calibration
from skinfield.calibrate.layer_comparison import LayerComparison as LayerComparison
from skinfield.calibrate.layer_comparison import LayerModel as LayerModel
from skinfield.calibrate.layer_comparison import compare_layers as compare_layers

"""Calibration from touches, forces and pressures."""

from skinfield.calibrate.by_touch import TouchCalibration as TouchCalibration
from skinfield.calibrate.by_touch import touch as touch

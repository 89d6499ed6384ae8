"""Calibration of taxels from recordings in which what presses them is known."""

from skinfield.calibrate.by_pressure import PressureCalibration as PressureCalibration
from skinfield.calibrate.by_pressure import pressure as pressure

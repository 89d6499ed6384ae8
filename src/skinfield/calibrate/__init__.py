"""Calibration from touches, forces and pressures."""

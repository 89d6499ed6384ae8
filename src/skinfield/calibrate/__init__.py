"""What known loads say about a skin."""

from skinfield.calibrate.scale import ScaleFit as ScaleFit
from skinfield.calibrate.scale import column_of as column_of
from skinfield.calibrate.scale import fit_scale as fit_scale

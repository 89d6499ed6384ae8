"""Test rig in software: positioners, actuator, indenter, load cell, and a skin."""

from skinfield.simulate.rig.run import RigRun as RigRun
from skinfield.simulate.rig.run import RigTruth as RigTruth
from skinfield.simulate.rig.run import run_rig as run_rig
from skinfield.simulate.rig.scenario import At as At
from skinfield.simulate.rig.scenario import BetweenThree as BetweenThree
from skinfield.simulate.rig.scenario import BetweenTwo as BetweenTwo
from skinfield.simulate.rig.scenario import ContactAccuracy as ContactAccuracy
from skinfield.simulate.rig.scenario import LoadCell as LoadCell
from skinfield.simulate.rig.scenario import LoadProfile as LoadProfile
from skinfield.simulate.rig.scenario import Loads as Loads
from skinfield.simulate.rig.scenario import LoadSeries as LoadSeries
from skinfield.simulate.rig.scenario import OverTaxels as OverTaxels
from skinfield.simulate.rig.scenario import Places as Places
from skinfield.simulate.rig.scenario import Pose as Pose
from skinfield.simulate.rig.scenario import Random as Random
from skinfield.simulate.rig.scenario import Raster as Raster
from skinfield.simulate.rig.scenario import Scenario as Scenario
from skinfield.simulate.rig.scenario import Temperature as Temperature
from skinfield.simulate.rig.scenario import Tool as Tool

"""Emulated electronics: from the change of each taxel's capacitance to counts in time."""

from skinfield.simulate.electronics.array import Defect as Defect
from skinfield.simulate.electronics.array import Defects as Defects
from skinfield.simulate.electronics.array import Electronics as Electronics
from skinfield.simulate.electronics.array import Hysteresis as Hysteresis
from skinfield.simulate.electronics.array import TaxelArray as TaxelArray
from skinfield.simulate.electronics.array import cyskin_electronics as cyskin_electronics
from skinfield.simulate.electronics.array import icub_electronics as icub_electronics
from skinfield.simulate.electronics.array import ideal_electronics as ideal_electronics
from skinfield.simulate.electronics.array import recording as recording
from skinfield.simulate.electronics.board import Board as Board
from skinfield.simulate.electronics.board import CySkinBoard as CySkinBoard
from skinfield.simulate.electronics.board import ICubBoard as ICubBoard
from skinfield.simulate.electronics.board import LinearBoard as LinearBoard
from skinfield.simulate.electronics.delivery import CrossTalk as CrossTalk
from skinfield.simulate.electronics.delivery import Delivery as Delivery
from skinfield.simulate.electronics.delivery import Sampling as Sampling
from skinfield.simulate.electronics.noise import Noise as Noise
from skinfield.simulate.electronics.noise import ThermalDrift as ThermalDrift

"""Values on a grid at one instant, and the contacts in them."""

from skinfield.fields.contact import Contact as Contact
from skinfield.fields.estimate import Estimate as Estimate
from skinfield.fields.noise import PressureNoise as PressureNoise

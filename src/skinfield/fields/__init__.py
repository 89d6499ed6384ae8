"""Values on a grid at one instant, and the contacts in them."""

from skinfield.fields.contact import Contact as Contact
from skinfield.fields.estimate import Estimate as Estimate
from skinfield.fields.uncertainty import ModelError as ModelError
from skinfield.fields.uncertainty import PressureError as PressureError
from skinfield.fields.uncertainty import PressureNoise as PressureNoise
from skinfield.fields.uncertainty import PressurePosterior as PressurePosterior
from skinfield.fields.uncertainty import Spread as Spread

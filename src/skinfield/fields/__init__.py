"""Values on a grid at one instant, and the contacts in them."""

from skinfield.fields.contact import Contact as Contact
from skinfield.fields.estimate import Estimate as Estimate
from skinfield.fields.model_error import ModelError as ModelError
from skinfield.fields.noise import PressureError as PressureError
from skinfield.fields.noise import PressureNoise as PressureNoise
from skinfield.fields.posterior import PressurePosterior as PressurePosterior
from skinfield.fields.spread import Spread as Spread

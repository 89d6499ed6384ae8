"""What the taxels see: layout, mechanics and grid make a linear map that solvers invert."""

from skinfield.observation.arguments import check_skin as check_skin
from skinfield.observation.deformation import Deformation as Deformation
from skinfield.observation.model import ObservationModel as ObservationModel
from skinfield.observation.model import Physics as Physics
from skinfield.observation.quantity import BaseStress as BaseStress
from skinfield.observation.quantity import Capacitance as Capacitance
from skinfield.observation.quantity import Gap as Gap
from skinfield.observation.quantity import Quantity as Quantity

"""What the taxels see: layout, mechanics and grid make a linear map that solvers invert."""

from skinfield.observation.model import BaseStress as BaseStress
from skinfield.observation.model import Capacitance as Capacitance
from skinfield.observation.model import Deformation as Deformation
from skinfield.observation.model import Gap as Gap
from skinfield.observation.model import ObservationModel as ObservationModel
from skinfield.observation.model import Physics as Physics
from skinfield.observation.model import Quantity as Quantity
from skinfield.observation.model import check_skin as check_skin

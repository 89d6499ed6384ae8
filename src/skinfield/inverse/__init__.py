"""Solvers: from an observation model to an inverse operator."""

from skinfield.inverse.contact_fit import ContactFit as ContactFit
from skinfield.inverse.gaussian_model import GaussianModel as GaussianModel
from skinfield.inverse.gaussian_model import TaxelSets as TaxelSets
from skinfield.inverse.linear import GaussianField as GaussianField
from skinfield.inverse.linear import Inverse as Inverse
from skinfield.inverse.linear import PseudoInverse as PseudoInverse
from skinfield.inverse.linear import Tikhonov as Tikhonov
from skinfield.inverse.non_negative import NonNegative as NonNegative
from skinfield.inverse.operator import ContactOperator as ContactOperator
from skinfield.inverse.operator import FieldOperator as FieldOperator
from skinfield.inverse.operator import Fit as Fit
from skinfield.inverse.operator import InverseOperator as InverseOperator
from skinfield.inverse.operator import Solver as Solver
from skinfield.inverse.sheet import Sheet as Sheet
from skinfield.inverse.sheet import SheetEstimate as SheetEstimate

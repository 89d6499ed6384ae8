"""Solvers: from an observation model to an inverse operator; and whether anything touches."""

from skinfield.solve.auto import Auto as Auto
from skinfield.solve.contact_fit import ContactFit as ContactFit
from skinfield.solve.gaussian_model import GaussianModel as GaussianModel
from skinfield.solve.gaussian_model import TaxelSets as TaxelSets
from skinfield.solve.linear import GaussianField as GaussianField
from skinfield.solve.linear import Inverse as Inverse
from skinfield.solve.linear import PseudoInverse as PseudoInverse
from skinfield.solve.linear import Tikhonov as Tikhonov
from skinfield.solve.non_negative import NonNegative as NonNegative
from skinfield.solve.operator import ContactOperator as ContactOperator
from skinfield.solve.operator import FieldOperator as FieldOperator
from skinfield.solve.operator import Fit as Fit
from skinfield.solve.operator import InverseOperator as InverseOperator
from skinfield.solve.operator import Solver as Solver
from skinfield.solve.sheet.sheet import Sheet as Sheet

"""Solvers: from an observation model to an inverse operator; and whether anything touches."""

from skinfield.solve.auto import Auto as Auto
from skinfield.solve.contact_fit import ContactFit as ContactFit
from skinfield.solve.gaussian_model import GaussianModel as GaussianModel
from skinfield.solve.gaussian_model import TaxelSet as TaxelSet
from skinfield.solve.linear import GaussianField as GaussianField
from skinfield.solve.linear import Inverse as Inverse
from skinfield.solve.linear import PseudoInverse as PseudoInverse
from skinfield.solve.linear import Tikhonov as Tikhonov
from skinfield.solve.non_negative import NonNegative as NonNegative
from skinfield.solve.operator import Data as Data
from skinfield.solve.operator import Fit as Fit
from skinfield.solve.operator import LinearOperator as LinearOperator
from skinfield.solve.operator import Operator as Operator
from skinfield.solve.operator import Solution as Solution
from skinfield.solve.operator import Solver as Solver
from skinfield.solve.sheet.sheet import Sheet as Sheet

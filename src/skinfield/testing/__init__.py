"""Contracts that third parties run on their own variants: subclass, set the fields, run pytest."""

from skinfield.testing.solver import SolverContract as SolverContract
from skinfield.testing.source import SourceContract as SourceContract

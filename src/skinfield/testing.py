"""Contract tests that a solver or a live source of one's own must pass."""

from skinfield.signal.contract import SourceContract as SourceContract
from skinfield.solve.contract import SolverContract as SolverContract

"""A sheet of thousands to millions of taxels."""

from skinfield.solve.sheet.estimate import SheetEstimate as SheetEstimate
from skinfield.solve.sheet.sheet import Sheet as Sheet

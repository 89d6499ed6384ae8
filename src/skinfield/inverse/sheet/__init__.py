"""A sheet of thousands to millions of taxels."""

from skinfield.inverse.sheet.estimate import SheetEstimate as SheetEstimate
from skinfield.inverse.sheet.sheet import Sheet as Sheet

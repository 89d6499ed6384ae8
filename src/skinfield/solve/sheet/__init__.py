"""A sheet of thousands to millions of taxels."""

from skinfield.solve.sheet.sheet import Sheet as Sheet

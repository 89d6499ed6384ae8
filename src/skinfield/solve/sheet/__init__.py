"""Sheet of thousands to millions of taxels, solved by conjugate gradients."""

from skinfield.solve.sheet.sheet import Sheet as Sheet

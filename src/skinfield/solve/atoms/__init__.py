"""Atoms: what single contacts look like, tabulated, and how they are fitted to readings."""

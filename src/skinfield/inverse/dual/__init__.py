"""Non-negative fields in the dual: as many unknowns as taxels, however many nodes."""

from pathlib import Path

from skinfield.inverse.atoms.stale import drop_stale

drop_stale(Path(__file__).parent)

"""Engine: all patches of a skin in one cycle, within one budget."""

from skinfield.reconstruct.engine.engine import Engine as Engine
from skinfield.reconstruct.engine.report import CycleReport as CycleReport
from skinfield.reconstruct.engine.results import MissingPatch as MissingPatch
from skinfield.reconstruct.engine.skin_contacts import SkinContacts as SkinContacts

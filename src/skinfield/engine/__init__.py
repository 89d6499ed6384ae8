"""The whole skin at run time: one budget for all patches of a cycle."""

from skinfield.engine.engine import Engine as Engine
from skinfield.engine.report import CycleReport as CycleReport
from skinfield.engine.report import PatchReport as PatchReport
from skinfield.engine.results import Estimates as Estimates
from skinfield.engine.results import MissingPatch as MissingPatch
from skinfield.engine.skin_contacts import SkinContacts as SkinContacts

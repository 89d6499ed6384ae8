"""A skin alive: the engine in its process, those who watch it, and those who read its estimates."""

from pathlib import Path

from skinfield.live.client import Live as Live
from skinfield.live.client import NotRunning as NotRunning
from skinfield.live.client import Snapshot as Snapshot
from skinfield.live.client import Stale as Stale
from skinfield.live.client import connect as connect
from skinfield.live.settings import LiveSettings as LiveSettings
from skinfield.live.supervisor import EngineFailed as EngineFailed
from skinfield.live.supervisor import Supervisor as Supervisor


def include_folder() -> Path:
    """Folder of ``skinfield_live.h``, for a C compiler's ``-I``; it finds the ring's by itself."""
    return Path(__file__).parent

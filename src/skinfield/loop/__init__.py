"""Loop: the process that answers a live skin, its supervisor, and clients of its ring."""

from pathlib import Path

from skinfield.loop.client import Live as Live
from skinfield.loop.client import NotRunning as NotRunning
from skinfield.loop.client import Snapshot as Snapshot
from skinfield.loop.client import Stale as Stale
from skinfield.loop.client import check_free as check_free
from skinfield.loop.client import connect as connect
from skinfield.loop.settings import LiveSettings as LiveSettings
from skinfield.loop.supervisor import EngineFailed as EngineFailed
from skinfield.loop.supervisor import Supervisor as Supervisor
from skinfield.reconstruct.engine.state import Answer as Answer
from skinfield.ring import State as State


def include_folder() -> Path:
    """Folder of ``skinfield_live.h``, for a C compiler's ``-I``; it finds the ring's by itself."""
    return Path(__file__).parent

"""Orders of a page that shows a recording and no live skin."""

from skinfield.viewer.desk import Desk
from skinfield.viewer.replay_feed import ReplayFeed


class ReplayDesk(Desk):
    """See `Desk`: all browsers play the same recording, and nothing else can be ordered.

    Parameters
    ----------
    replay : ReplayFeed
    """

    mode = "replay"

    def __init__(self, replay: ReplayFeed) -> None:
        super().__init__()
        self.shared = replay

"""A bar that says how many readings are done in a second."""

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class _Speed(ProgressColumn):
    """Readings in a second, of the last half minute."""

    def render(self, task: Task) -> Text:
        """Such as 120,000 readings/s."""
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:,.0f} readings/s")


def readings_progress() -> Progress:
    """Bar on stderr with readings per second and the time left; it goes away when it is done."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        _Speed(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )

"""Recordings by others as sections, where their folder is at hand."""

from pathlib import Path

from skinfield.experiments.recorded.finding import AbsentData
from skinfield.experiments.recorded.real_data import FINDINGS, section_of
from skinfield.experiments.section import Missing, Section
from skinfield.experiments.settings import Settings

RECORDED = tuple(name for name, _ in FINDINGS)


def recorded(settings: Settings, name: str) -> Section | Missing:
    """The section of one kind of recording, or why it is missing."""
    if not settings.data:
        return Missing(
            f"recorded data ({name}): no folder of recordings was given, see --data of "
            "skinfield experiments"
        )
    try:
        return section_of(dict(FINDINGS)[name](Path(settings.data)))
    except AbsentData as absent:
        return Missing(f"recorded data ({name}): {absent}")

"""Settings of the fit of contacts, and what they may be."""

from dataclasses import dataclass
from typing import Annotated

from skinfield.errors import check_type
from skinfield.settings import Positive, Range, Section


@dataclass(frozen=True, kw_only=True)
class FitSettings(Section):
    """What `ContactFit` goes by; its parameters are listed there."""

    most_contacts: Annotated[int, Range(1, 64, "atoms that are sought")] = 8
    false_alarm_rate: Annotated[float, Range(1e-12, 0.5, "a share of readings")] = 1e-3
    typical_radius: Annotated[float, Positive("of what touches, in metres")] = 6e-3
    model_error: Annotated[float, Range(0.0, 0.5, "part of the highest reading")] = 0.02
    starts: Annotated[int, Range(1, 64, "places from which each is sought")] = 8
    warm: bool = True
    common_mode: Annotated[float, Range(0.0, 1e6, "in standard deviations of the noise")] = 5.0
    check_mechanics: bool = True

    def check(self) -> None:
        """See `Section`."""
        check_type("check_mechanics", self.check_mechanics, bool, "whether others are compared")
        check_type("warm", self.warm, bool, "whether to start from the reading before")

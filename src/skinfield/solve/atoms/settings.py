"""Settings of the fit of contacts, and what they may be."""

from dataclasses import dataclass

from skinfield.errors import check_count, check_positive, check_range, check_type


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """What `ContactFit` goes by; its parameters are listed there."""

    most_contacts: int = 8
    false_alarm_rate: float = 1e-3
    typical_radius: float = 6e-3
    model_error: float = 0.02
    starts: int = 8
    warm: bool = True
    common_mode: float = 5.0
    check_mechanics: bool = True

    def __post_init__(self) -> None:
        check_count("most_contacts", self.most_contacts, 1, 64, "atoms that are sought")
        check_count("starts", self.starts, 1, 64, "places from which each is sought")
        check_type("check_mechanics", self.check_mechanics, bool, "whether others are compared")
        check_type("warm", self.warm, bool, "whether to start from the reading before")
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        check_positive("typical_radius", self.typical_radius, "of what touches, in metres")
        check_range(
            "common_mode", self.common_mode, 0.0, 1e6, "in standard deviations of the noise"
        )
        check_range("model_error", self.model_error, 0.0, 0.5, "part of the highest reading")

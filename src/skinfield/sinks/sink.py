"""What every sink does."""

from abc import ABC, abstractmethod
from types import TracebackType
from typing import Protocol, Self

from skinfield.fields import Estimate


class Sink(Protocol):
    """Anything that takes estimates, one or many at a time, until it is closed."""

    def write(self, estimate: Estimate, /) -> None:
        """Take the estimate of one reading or of a run of readings."""
        ...

    def close(self) -> None:
        """Finish; the result has its name only now."""
        ...


class Closing(ABC):
    """A `with` block around a sink: closed at its end, discarded on an error."""

    @abstractmethod
    def close(self) -> None:
        """Finish."""

    @abstractmethod
    def discard(self) -> None:
        """Give up: nothing is left, and what stood at the result's place stays."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.discard()

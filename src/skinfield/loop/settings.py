"""Settings of a live skin: everything that its engine process needs to know."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from skinfield.elastic import BondedLayer, Capacitance, Layer, Mechanics, Quantity
from skinfield.errors import InputError, check_offers, check_type
from skinfield.loop.realtime.setup import RealTime
from skinfield.loop.runtime_parameters import HEAVIEST, SLOWEST, Tuning
from skinfield.settings import Positive, Range, Section
from skinfield.signal import Calibration, Convention, Source
from skinfield.signal.faults import chosen_rows
from skinfield.skin import Patch, Skin
from skinfield.solve import Auto, Solver

RUNGS = (10, 20, 40)


@dataclass(frozen=True, kw_only=True, eq=False)
class LiveSettings(Section):
    """A skin, where its readings come from, and how they are answered.

    Parameters
    ----------
    skin : Skin or Patch
    sources : tuple of Source
        Their ports are counted one after the other.
    name : str
        By which readers find the ring.
    layer : Layer
    mechanics, quantity, solver
        As `Engine` takes them; by default `Auto`.
    rungs : tuple of int
        Nodes along the sides of the grids, from coarse to fine.
    board : Convention, optional
        What a count means; default by the range of the counts.
    gain : float, counts per unit of ΔC/C₀, optional
        Default a guess for the board.
    calibration : mapping from names of patches to Calibration
        Patches without one take their baseline while the engine starts, of an untouched skin.
    keep, without : tuple of int
        Rows of taxels, counted on from patch to patch, to use or to leave out, whatever is faulty.
    relative : bool
        Whether forces hold up to one factor only.
    rate : float, 1/s, or None
        Of cycles; None for a cycle whenever readings arrive.
    budget : float, s, optional
        For the reconstruction within one cycle. Default a quarter of a period, at most 5 ms.
    deadline : float, s, optional
        After the beginning of a cycle, when its estimates must be there: later is counted as late.
        Default one period, or 1 ms in event mode.
    tare_seconds : float, s
        For the baseline.
    stale_after : float, s, optional
        Age at which a taxel's reading is left out. Default five times the longest interval that is
        usual for it, at least 50 ms.
    rows : int
        Contacts told of each patch, at most.
    threshold : float, N
        Contacts of a smaller force are not told.
    smoothing : float, s
        Time constant of a first-order low-pass of what each taxel reads; 0: none.
    log_bytes : int, optional
        Of the ring's log of readings: a power of two. Default some seconds of all taxels at the
        engine's rate, 16 to 256 MB.
    real_time : RealTime
    prefetch : bool
        Wake shortly before each cycle is due as well, and take in what is there already, so that
        the estimate is ready sooner after it. Only at a rate, and where real time is granted.
    tree : mapping
        Of the settings that this was made from, in plain values: for readers and recordings.
    """

    skin: Skin
    sources: tuple[Source, ...]
    name: str = "skin"
    layer: Layer = field(default_factory=Layer)
    mechanics: Mechanics = field(default_factory=BondedLayer)
    quantity: Quantity = field(default_factory=Capacitance)
    solver: Solver = field(default_factory=Auto)
    rungs: tuple[int, ...] = RUNGS
    board: Convention | None = None
    gain: float | None = None
    calibration: Mapping[str, Calibration] = field(default_factory=dict)
    keep: tuple[int, ...] = ()
    without: tuple[int, ...] = ()
    relative: bool = False
    rate: Annotated[float | None, Positive("cycles per second; None: as readings come")] = 1000.0
    budget: Annotated[float | None, Positive("seconds")] = None
    deadline: Annotated[float | None, Positive("seconds")] = None
    tare_seconds: Annotated[float, Positive("seconds")] = 1.0
    stale_after: Annotated[float | None, Positive("seconds")] = None
    rows: int = 8
    threshold: Annotated[float, Range(0.0, HEAVIEST, "N, of contacts that are told")] = 0.0
    smoothing: Annotated[float, Range(0.0, SLOWEST, "s, a time constant; 0: none")] = 0.0
    log_bytes: int | None = None
    real_time: RealTime = field(default_factory=RealTime)
    tree: Mapping[str, Any] = field(default_factory=dict)
    prefetch: bool = True

    def check(self) -> None:
        """See `Section`."""
        if isinstance(self.skin, Patch):
            object.__setattr__(self, "skin", Skin((self.skin,), name=self.skin.name))
        check_type("skin", self.skin, Skin, "the patches, as load_layout returns them")
        for source in self.sources:
            check_offers("sources", source, ("open",), "objects such as PacketUdp()")
        if not self.sources:
            raise InputError("sources is empty, expected one or more: where readings come from")
        chosen_rows(self.keep, self.without, sum(map(len, self.skin)))
        unknown = set(self.calibration) - {patch.name for patch in self.skin}
        if unknown:
            raise InputError(
                f"calibration names {sorted(unknown)[0]!r}, expected patches of the skin: "
                f"{', '.join(patch.name for patch in self.skin)}"
            )

    @property
    def period(self) -> float:
        """Of a cycle, s; in event mode the longest wait for a reading."""
        return 0.05 if self.rate is None else 1.0 / self.rate

    @property
    def time_to_answer(self) -> float:
        """For the reconstruction, s."""
        if self.budget is not None:
            return self.budget
        return 500e-6 if self.rate is None else min(0.25 / self.rate, 5e-3)

    @property
    def tuning(self) -> Tuning:
        """What the engine begins with, of what can be changed while it answers."""
        budget = self.time_to_answer
        return Tuning(deadline=budget, threshold=self.threshold, smoothing=self.smoothing)

    @property
    def due_after(self) -> float:
        """When a cycle is late, s after it was due."""
        if self.deadline is not None:
            return self.deadline
        return 1e-3 if self.rate is None else 1.0 / self.rate

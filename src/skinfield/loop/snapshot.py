"""Snapshot of a running skin: one cycle, as its readers get it."""

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError
from skinfield.estimate import Estimate, Wrench
from skinfield.estimate.row_contacts import contact_of_row
from skinfield.estimate.wrench import wrenches_by_link
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop.model_config import ModelConfig, Models
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.plot import Pictured, Place, facts_table, number, plural, plus_minus
from skinfield.reconstruct.engine.state import Answer

LISTED = 12  # contacts in a table of facts


class Stale(InputError):
    """No estimate that is young enough: nothing is ever returned in its place."""


class Snapshot(Pictured, Mapping[str, Estimate]):
    """One cycle of a live skin: estimates by the names of the patches.

    Attributes
    ----------
    number : int
        Of the cycle.
    age : float, s
        Of the newest reading in it when it was fetched; infinite before the first.
    stamp_ns : int, ns
        Of that reading, since the epoch.
    fetched : float, s
        When it was fetched, by `time.monotonic`.
    fresh : bool
        Whether the cycle had a new reading; else it holds the answers of an earlier one.
    contacts : structured (N,) array
        On all patches, with `track`, `patch` (its number), `position` (m, in the patch's frame),
        `normal_force` (N), `force_std` (N), `place_std` (m), `area` (m²) and more; see its dtype.
    patches : structured (P,) array
        What is known of each patch: answer, rung, gap, stamp_ns, fresh, force ...

    Its estimates have the `notes` that the engine published last, about once a second.
    """

    def __init__(
        self,
        slot: CycleSlot,
        number: int,
        models: Models,
        wall_ns: int,
        notes: Callable[[], Mapping[str, Any] | None] = dict,
    ) -> None:
        self.number, self._notes, self.fetched = number, notes, time.monotonic()
        self.slot, self._models = slot, models
        self.patches: NDArray[Any] = slot.patches
        self.contacts: NDArray[Any] = slot.used_contacts()
        self.stamp_ns = int(slot.patches["stamp_ns"].max(initial=0))
        self.age = (wall_ns - self.stamp_ns) * 1e-9 if self.stamp_ns else float("inf")
        self.fresh = bool(slot.head[CycleHead.FRESH])
        self._names = [patch.name for patch in models.model_config.skin]
        self._made: dict[str, Estimate] = {}

    def __getitem__(self, name: str) -> Estimate:
        if name not in self._names:
            raise InputError(f"no patch is named {name!r}, expected one of {self._names}")
        place = self._names.index(name)
        if self.patches["answer"][place] == int(Answer.MISSING):
            age = self.ages()[name]
            raise Stale(
                f"patch {name!r} has no answer: its newest reading is {age:.3g} s old; see "
                "`skinfield status`"
            )
        if name not in self._made:
            said = (self._notes() or {}).get("readings", {}).get(name, ())
            known = self.slot, place, self.took, self.late, tuple(said)
            self._made[name] = self._models.estimate(*known)
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        there = self.patches["answer"] != int(Answer.MISSING)
        return (name for name, known in zip(self._names, there, strict=True) if known)

    def __len__(self) -> int:
        return int((self.patches["answer"] != int(Answer.MISSING)).sum())

    def __repr__(self) -> str:
        contacts = plural(len(self.contacts), "contact")
        patches = plural(len(self._names), "patch", "patches")
        age = f"{number(self.age)} s old" if np.isfinite(self.age) else "no reading yet"
        return f"Snapshot({patches}, {contacts}, {number(self.force)} N, {age})"

    def plot(self, ax: Place = None, *, patch: str | None = None) -> Any:
        """Draw the answer of one patch, as `Estimate.plot` does.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.
        patch : str, optional
            Its name. Default the one that is pressed most.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        Stale
            If the patch has no answer, or none has.
        InputError
            For a name that is none of a patch, if `ax` is something else, or Matplotlib is not
            installed.
        """
        if patch is None:
            there = self.patches["answer"] != int(Answer.MISSING)
            loads = np.where(there, self.patches["force"], -np.inf)
            patch = self._names[int(np.argmax(loads))]
        return self[patch].plot(ax)

    def _facts(self) -> Mapping[str, str]:
        facts = {
            "Snapshot": f"cycle {self.number}",
            "force": f"{number(self.force)} N",
            "age": f"{number(self.age)} s" if np.isfinite(self.age) else "no reading yet",
        }
        for contact in self.contacts[:LISTED]:
            force = plus_minus(float(contact["normal_force"]), float(contact["force_std"]))
            place = ", ".join(f"{x * 1e3:.1f}" for x in contact["position"].tolist())
            name = self._names[int(contact["patch"])]
            facts[f"contact {int(contact['track'])}"] = f"{force} N at ({place}) mm of {name}"
        if len(self.contacts) > LISTED:
            facts["…"] = f"{len(self.contacts) - LISTED} more contacts"
        return facts

    def _repr_html_(self) -> str:
        """Picture of the patch that is pressed most, if any has an answer, and table."""
        return super()._repr_html_() if len(self) else facts_table(self)

    @property
    def solvers(self) -> list[str]:
        """Name of the solver that answered each patch; of `Auto` the one that it chose."""
        return [self._models.solver_of(answer) for answer in self.patches["answer"].tolist()]

    @property
    def took(self) -> float:
        """From the beginning of the cycle to its answer, s."""
        return float(self.slot.head[CycleHead.READY_NS] - self.slot.head[CycleHead.WAKE_NS]) * 1e-9

    @property
    def late(self) -> bool:
        """Whether the answer came after its deadline."""
        return bool(int(self.slot.head[CycleHead.FLAGS]) & CycleFlag.LATE)

    def ages(self) -> dict[str, float]:
        """Age of each patch's newest reading, s; infinite where none ever came."""
        wall = self.stamp_ns + self.age * 1e9 if self.stamp_ns else 0.0
        stamps = self.patches["stamp_ns"].tolist()
        return {
            name: (wall - stamp) * 1e-9 if stamp else float("inf")
            for name, stamp in zip(self._names, stamps, strict=True)
        }

    @property
    def model_config(self) -> ModelConfig:
        """What the answers follow from."""
        return self._models.model_config

    @property
    def prepared(self) -> bool:
        """Whether deformation and uncertainty are there at once: the first time takes seconds."""
        return self._models.prepared

    def prepare(self) -> None:
        """Prepare deformation and uncertainty, of this cycle and those after it; takes seconds."""
        _ = self._models.rungs

    @property
    def wrenches(self) -> dict[str, Wrench]:
        """Wrench of all contacts on each link, about its origin and in its frame, with its age.

        A link is there once all of its patches have an answer.
        """
        skin, answers = self.model_config.skin, self.patches["answer"].tolist()
        missing = {
            patch.link
            for patch, answer in zip(skin, answers, strict=True)
            if answer == int(Answer.MISSING)
        }
        ages, none, each = self.ages(), np.empty(0, np.int64), []
        for place, patch in enumerate(skin):
            if patch.link not in missing:
                rows = self.contacts[self.contacts["patch"] == place]
                contacts = [contact_of_row(patch, row, none) for row in rows]
                stamp = int(self.patches["stamp_ns"][place])
                known = patch.link_from_patch, stamp, ages[patch.name]
                each.append((patch.link, Wrench.of(contacts, *known)))
        return wrenches_by_link(each)

    def indentation(self, name: str) -> Floats | None:
        """Displacement of a patch into the skin, (K,) m; None until it is prepared."""
        return self[name].indentation if self.prepared else None

    def noise_pressure(self, name: str) -> Floats | None:
        """How strong a pressure noise alone makes of a linear answer; None until it is prepared.

        One standard deviation on the nodes of the patch's answer, (K,) Pa.
        """
        if not self.prepared:
            return None
        place = self._names.index(name)
        return self._models.noise_pressure(place, int(self.patches["rung"][place]))

    def taxels(self, name: str) -> tuple[NDArray[Any], NDArray[np.bool_], Floats]:
        """Values, validity and noise of a patch's taxels, (L,) each, in the quantity's unit."""
        place = self._names.index(name)
        its = slice(self._models.starts[place], self._models.starts[place + 1])
        valid = self.slot.valid[its].astype(np.bool_)
        return self.slot.values[its], valid, self._models.noise_std[its]

    @property
    def readings(self) -> NDArray[np.float32]:
        """Newest counts of all taxels, patch by patch, (L,)."""
        return self.slot.counts

    @property
    def force(self) -> float:
        """Sum of the normal forces of all contacts, N."""
        return float(self.patches["force"].sum())

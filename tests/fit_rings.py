"""A ring of a contact fit, with answers that are made up."""

import time
from typing import Any, Self

import numpy as np

from skinfield.estimate.live_contacts import CONTACT
from skinfield.loop.fit_ring import (
    LOG_BYTES,
    SLOTS,
    FitSlot,
    Fitted,
    describe,
    fit_name,
    slot_fields,
    status_fields,
    write_engine,
)
from skinfield.ring import Ring, State

ROWS = 8


def contact(x: float = 0.0, y: float = 0.0, force: float = 1.0, **more: Any) -> Any:
    """A row of CONTACT."""
    row = np.zeros(1, CONTACT)
    row["x"], row["y"], row["normal_force"], row["normal"] = x, y, force, (0.0, 0.0, 1.0)
    row["position"] = x, y, 0.0
    for name, value in more.items():
        row[name] = value
    return row


class FakeFit:
    """Publishes an answer whenever told.

    Parameters
    ----------
    name : str
        Of the engine's ring.
    patches : sequence of str
    nodes : int
    """

    def __init__(self, name: str, patches: tuple[str, ...] = ("arm",), nodes: int = 16) -> None:
        self.master = FitSlot.empty(len(patches), nodes, ROWS)
        fields = slot_fields(len(patches), nodes, ROWS), status_fields()
        self.ring = Ring.create(fit_name(name), *fields, describe(name, patches), SLOTS, LOG_BYTES)
        self.ring.set_state(State.RUNNING)

    def tell(
        self,
        *rows: Any,
        patch: int = 0,
        state: Fitted = Fitted.DONE,
        stamp_ns: int | None = None,
        told_ns: int | None = None,
        pressure: Any = (),
        engine: Any = None,
        touched: int = 1,
    ) -> None:
        """Publish what was found on one patch, and of the others what there was."""
        slot = self.master
        told, found = slot.patches[patch], np.concatenate([np.zeros(0, CONTACT), *rows])
        told["state"], told["contacts"], told["touched"] = int(state), len(found), touched
        told["stamp_ns"] = time.time_ns() if stamp_ns is None else stamp_ns
        told["force"] = found["normal_force"].sum()
        if engine is not None:
            write_engine(told, engine)
        slot.contacts[patch][: len(found)] = found
        slot.forms[patch]["shape"], slot.forms[patch]["radius"] = 1, 5e-3
        slot.pressure[patch] = 0.0
        slot.pressure[patch][: len(pressure)] = pressure
        slot.told_ns[0] = time.time_ns() if told_ns is None else told_ns
        FitSlot.of(self.ring.begin()).copy_from(slot)
        self.ring.publish()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Take the ring away."""
        self.ring.unlink()
        self.ring.close()

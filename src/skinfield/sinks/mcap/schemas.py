"""What the channels' schemas say: text to read for our own layouts, JSON Schema for the rest."""

import json

from skinfield.acquisition.block import __doc__ as _BLOCKS
from skinfield.acquisition.recorded import __doc__ as _RECORDED
from skinfield.acquisition.recorded_fit import __doc__ as _FIT

TEXT = "x-text"  # encoding of a schema that is prose
BLOCKS_ENCODING = "x-skinfield-blocks"
CYCLE_ENCODING = "x-skinfield-cycle"
FIT_ENCODING = "x-skinfield-fit"
_KINDS = """\
Kinds, and their payloads: 1, 2, 3: counts as uint8, uint16, float32, one per channel. 4: a bit per
channel, out of range. 5: int64, a source (its number stands for the channel) came up (1) or went
down (0). 6: int64, messages of a source that are known to be lost. 7: of as many taxels six float64
each: baseline, gain, noise (counts), alive (0 or 1), noise in the quantity's unit, and the age in s
at which a reading is left out. 8: of the engine's tuning as many float64: nodes a side of the
finest grid for answers (0: as time allows), s for a reconstruction, N below which contacts are not
told, s of the readings' low-pass, patch of the focus (-1: none), its lower corner and its upper, m.
9: where the low-pass of as many taxels stands: float64 in the quantity's unit and int64 stamp. 10:
as many characters of JSON: solver, and which of the ring's engine processes it is.
Status bits: 1 no answer, 2 not connected, 4 out of range, 8 invalid.
"""
_CYCLE = """\
One cycle of the engine, little-endian:

offset bytes what
0      2     version of this layout (uint16), 1
2      2     bytes of this head (uint16), 96
4      4     flags (uint32): 1 key, 2 late, 4 overrun, 8 first of a new engine process
8      8     number (int64)
16     8     due_ns (int64), monotonic clock
24     8     wake_ns
32     8     acquired_ns
40     8     done_ns
48     8     wall_ns, since the epoch
56     8     position in the ring's log up to which blocks were applied (int64, bytes)
64     4     rows of the script (uint32)
68     4     columns of the script
72     4     contacts
76     4     bytes of a contact
80     4     patches
84     4     bytes of a patch
88     8     0
96           script (int64, row by row), contacts, patches

The fields of a contact and of a patch are in the channel's metadata as JSON.
"""
_FIT_HEAD = """\
Its head:

offset bytes what
0      2     version of this layout (uint16), 1
2      2     bytes of this head (uint16), 56
4      4     patches of the skin (uint32)
8      8     when the fit published it, ns since the epoch (int64)
16     8     number of the answer, counted by each fit from 1; 0: there is none any more (int64)
24     4     nodes of the finest grid of a patch (uint32, as the following)
28     4     contacts of a patch, at most
32     4     patches in this message
36     4     bytes of a patch
40     4     contacts in this message
44     4     bytes of a contact
48     4     bytes of a form
52     4     nodes with pressure in this message
56           places, how many nodes have pressure, patches, contacts, forms, nodes, pressures

The fields of a patch, a contact and a form are in the channel's metadata as JSON.
"""


def _object(title: str, **properties: object) -> bytes:
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "type": "object",
        "properties": properties,
    }
    return json.dumps(schema).encode()


_QUANTILES = {
    "type": "object",
    "properties": {key: {"type": "number"} for key in ("p50", "p99", "p999", "max")},
}
BLOCKS_SCHEMA = ("skinfield.Blocks", TEXT, f"{_RECORDED}\n{_BLOCKS}\n{_KINDS}".encode())
CYCLE_SCHEMA = ("skinfield.Cycle", TEXT, _CYCLE.encode())
FIT_SCHEMA = ("skinfield.Fit", TEXT, f"{_FIT}\n{_FIT_HEAD}".encode())
TIMING_SCHEMA = (
    "skinfield.Timing",
    "jsonschema",
    _object(
        "skinfield.Timing",
        wall_ns={"type": "integer"},
        cycles={"type": "integer"},
        late={"type": "integer"},
        wake_us=_QUANTILES,
        latency_us=_QUANTILES,
        counters={"type": "object"},
    ),
)
EVENT_SCHEMA = (
    "skinfield.Event",
    "jsonschema",
    _object(
        "skinfield.Event",
        wall_ns={"type": "integer"},
        kind={"type": "string"},
        text={"type": "string"},
    ),
)

"""Where everything of a ring lies: decided for a new one, read from a file; see `header`."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from skinfield.errors import FileError, InputError, check_count
from skinfield.ring.fields import ENTRY, Field, Placed, place, read_table, table
from skinfield.ring.header import MAGIC, PAGE, SLOT_HEADER, VERSION, Header


@dataclass(frozen=True)
class Layout:
    """Header, fields and description of a ring.

    Attributes
    ----------
    header : Header
    slot_fields, status_fields : tuples of Placed
    description : bytes
        JSON.
    """

    header: Header
    slot_fields: tuple[Placed, ...]
    status_fields: tuple[Placed, ...]
    description: bytes

    @classmethod
    def plan(
        cls,
        slot_fields: Sequence[Field],
        status_fields: Sequence[Field],
        description: Mapping[str, Any],
        slots: int,
        log_bytes: int,
        created_ns: int = 0,
    ) -> Self:
        """Decide where everything lies; each part begins with a page.

        Raises
        ------
        InputError
            If a field, the description or a number cannot be used.
        """
        _check_sizes(slots, log_bytes)
        text = _json(description)
        in_slot, slot_bytes = place("slot_fields", slot_fields, SLOT_HEADER)
        in_status, status_bytes = place("status_fields", status_fields, 0)
        description_offset = _page(PAGE + ENTRY * (len(in_slot) + len(in_status)))
        status_offset = _page(description_offset + len(text))
        slots_offset = _page(status_offset + status_bytes)
        log_offset = _page(slots_offset + slots * slot_bytes)
        header = Header(
            magic=MAGIC,
            version=VERSION,
            header_bytes=PAGE,
            file_bytes=log_offset + log_bytes,
            fields_offset=PAGE,
            slot_fields=len(in_slot),
            status_fields=len(in_status),
            description_offset=description_offset,
            description_bytes=len(text),
            status_offset=status_offset,
            status_bytes=status_bytes,
            slots_offset=slots_offset,
            slot_bytes=slot_bytes,
            slots=slots,
            log_offset=log_offset,
            log_bytes=log_bytes,
            created_ns=created_ns,
        )
        return cls(header, in_slot, in_status, text)

    def beginning(self) -> bytes:
        """Everything up to the status, for a new file."""
        data = bytearray(self.header.status_offset)
        entries = table(self.slot_fields) + table(self.status_fields)
        for start, part in (
            (0, self.header.pack()),
            (self.header.fields_offset, entries),
            (self.header.description_offset, self.description),
        ):
            data[start : start + len(part)] = part
        return bytes(data)

    @classmethod
    def read(cls, data: memoryview, where: str) -> Self:
        """Read and check the layout of a file; every offset lies within it afterwards.

        Parameters
        ----------
        data : memoryview
            The whole file.
        where : str
            For errors.

        Raises
        ------
        FileError
            If it is no ring, of another version, or damaged.
        """
        header = Header.read(data, where)
        first, start = header.fields_offset, header.description_offset
        middle = first + ENTRY * header.slot_fields
        return cls(
            header,
            read_table(data, first, header.slot_fields, SLOT_HEADER, header.slot_bytes, where),
            read_table(data, middle, header.status_fields, 0, header.status_bytes, where),
            bytes(data[start : start + header.description_bytes]),
        )

    def described(self, where: str) -> dict[str, Any]:
        """Read the description.

        Raises
        ------
        FileError
            If it is no JSON object.
        """
        try:
            found = json.loads(self.description.decode())
        except (ValueError, RecursionError) as error:
            raise FileError(f"description of {where} is damaged, expected JSON: {error}") from error
        if not isinstance(found, dict):
            raise FileError(f"description of {where} is damaged, expected a JSON object")
        return found

    def difference(self, other: "Layout") -> str:
        """Say where another ring differs in fields or sizes; nothing where it does not."""
        for what, ours, theirs in (
            ("slots", self.header.slots, other.header.slots),
            ("bytes of the log", self.header.log_bytes, other.header.log_bytes),
        ):
            if ours != theirs:
                return f"{ours} {what} are asked for, it has {theirs}"
        pairs = (self.slot_fields, other.slot_fields), (self.status_fields, other.status_fields)
        for asked, there in pairs:
            for placed in asked:
                if placed not in there:
                    return f"{placed.field} is asked for, it has none at that place"
            if asked != there:
                return f"it has {len(there)} fields where {len(asked)} are asked for"
        return ""


def _check_sizes(slots: int, log_bytes: int) -> None:
    check_count("slots", slots, 2, 1 << 20, "slots, so that readers have time to copy one")
    check_count("log_bytes", log_bytes, PAGE, 1 << 36, "bytes of the log")
    if log_bytes & (log_bytes - 1):
        raise InputError(
            f"log_bytes is {log_bytes}, expected a power of two: "
            f"take {1 << int(log_bytes).bit_length()}"
        )


def _json(description: Mapping[str, Any]) -> bytes:
    try:
        return json.dumps(dict(description), allow_nan=False).encode()
    except (TypeError, ValueError) as error:
        raise InputError(
            "description cannot be written as JSON, expected a mapping of plain finite values: "
            f"{error}"
        ) from error


def _page(offset: int) -> int:
    return -(-offset // PAGE) * PAGE

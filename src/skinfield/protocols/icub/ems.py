"""CAN messages as iCub's Ethernet boards pass them on: ``EOarray_of_skincandata_t``.

====== ===== =====================================================================
offset bytes what
====== ===== =====================================================================
0      1     capacity, items
1      1     size of an item: 10 bytes
2      1     items in it
3      1     of the board's own
4      10 n  items: ``length << 12 | identifier`` (uint16, little-endian), 8 of data
====== ===== =====================================================================

The protocol around it, in which boards send such arrays, is not read here.
"""

from skinfield.acquisition import CanMessages, Count
from skinfield.acquisition.block import Octets
from skinfield.errors import InputError, Ints, check_count

CAPACITY = 24  # items; 244 bytes. Older boards had 9 or 12
ITEM_BYTES = 10
HIGHEST_ID = 0x7FF


def array_of_messages(
    messages: CanMessages, first: int, count: int, capacity: int = CAPACITY
) -> bytes:
    """Bytes of an array with messages `first` to `count`; those of absent items are zeros.

    Raises
    ------
    InputError
        If they are more than `capacity`, or one has an extended identifier or more than 8 octets.
    """
    check_count("capacity", capacity, 1, 255, "items of an array")
    check_count("first", first, 0, len(messages), "row of the messages")
    check_count("count", count, first, min(len(messages), first + capacity), "row behind the last")
    items = bytearray([capacity, ITEM_BYTES, count - first, 0])
    for row in range(first, count):
        identifier, length = int(messages.ids[row]), int(messages.lengths[row])
        if identifier > HIGHEST_ID or length > 8:
            raise InputError(
                f"message {row} has identifier {identifier:#x} and {length} octets, expected 11 "
                "bits and at most 8 octets: an array holds standard messages only"
            )
        items += (length << 12 | identifier).to_bytes(2, "little")
        items += messages.data[row, :length].tobytes().ljust(8, b"\0")
    return bytes(items.ljust(4 + ITEM_BYTES * capacity, b"\0"))


def messages_of_array(
    octets: Octets,
    length: int,
    messages: CanMessages,
    first: int,
    stamp_ns: int,
    counters: Ints,
) -> int:
    """Messages of one array, into rows from `first` on; allocates nothing.

    Parameters
    ----------
    octets : (N,) uint8 array
    length : int
        Of it that is the array; bytes behind its last item are passed over.
    counters : (len(Count),) int64 array
        MALFORMED goes up by one where the bytes are no such array; then none of it is taken.

    Returns
    -------
    int
        The row behind the last one.

    Raises
    ------
    InputError
        If `messages` has too few rows left; 255 always do.
    """
    from skinfield.protocols.icub import ems_kernel

    check_count("first", first, 0, len(messages), "row of the messages")
    end = ems_kernel.messages_of_array(
        octets,
        length,
        messages.ids,
        messages.lengths,
        messages.data,
        messages.stamp_ns,
        first,
        stamp_ns,
    )
    if end == ems_kernel.NO_ROOM:
        raise InputError(
            f"messages have {len(messages) - first} rows left, expected {int(octets[2])}: hand in "
            "more room"
        )
    if end == ems_kernel.NO_ARRAY:
        counters[Count.MALFORMED] += 1
        return first
    return int(end)

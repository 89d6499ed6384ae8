"""Decompression of LZF, the packing of PCL's `binary_compressed` point clouds."""

from skinfield.errors import InputError


def decompress(data: bytes, size: int) -> bytes:
    """Unpack LZF to exactly `size` bytes.

    A control byte below 32 is followed by that many + 1 literal bytes; any other holds the length
    (3 bits, a further byte when all are set, plus 2) and the distance (13 bits, plus 1) of a copy
    from what was unpacked before.

    Raises
    ------
    InputError
        When the data end early, point before their start, or unpack to another size.
    """
    out, at = bytearray(), 0
    try:
        while at < len(data) and len(out) <= size:
            control = data[at]
            at += 1
            if control < 32:
                literal = data[at : at + control + 1]
                if len(literal) <= control:
                    raise IndexError
                out += literal
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += data[at]
                at += 1
            distance = ((control & 31) << 8 | data[at]) + 1
            at += 1
            if distance > len(out):
                raise IndexError
            for _ in range(length + 2):  # byte by byte: a copy may overlap itself
                out.append(out[-distance])
    except IndexError:
        raise InputError(f"LZF data are broken at byte {at} of {len(data)}") from None
    if len(out) != size:
        raise InputError(f"LZF data unpack to {len(out)} bytes, expected {size}")
    return bytes(out)

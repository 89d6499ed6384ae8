"""Vectors out of the text carrier's lines, compiled: a line with a stamp, a line of numbers."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets, Words
from skinfield.acquisition.kernel import BYTES, FLOATS, SHORTS, begin_block
from skinfield.errors import Floats, Ints

NEWLINE, RETURN, BLANK, TAB, COMMA = 10, 13, 32, 9, 44
ZERO, NINE, POINT, PLUS, MINUS = 48, 57, 46, 43, 45
DATA, DATA_ONLY, QUIT, ACKNOWLEDGED = 100, 68, 113, 60  # d, D, q, <
EXPONENTS = (101, 69)  # e, E
DIGITS = 18  # of a number that are told apart; more than a double has
RECEIVED, READINGS, LOST, MALFORMED = 0, 1, 2, 4  # as `Count`
SEEN, LAST, ENDED, LENGTH = 0, 1, 2, 3  # of the state
NO_NUMBER = -1
NONE = -1


@njit(cache=True, nogil=True)
def line_end(data: Octets, at: int, used: int) -> int:
    """Index of the next end of a line; -1 if there is none."""
    while at < used:
        if data[at] == NEWLINE:
            return at
        at += 1
    return NONE


@njit(cache=True, nogil=True)
def word(data: Octets, at: int, end: int) -> float:
    """What three letters mean: nan, inf; 0 if anything else."""
    if end - at < 3 or (at + 3 < end and data[at + 3] > BLANK and data[at + 3] != COMMA):
        return 0.0
    if data[at] == 110 and data[at + 1] == 97 and data[at + 2] == 110:
        return np.nan
    if data[at] == 105 and data[at + 1] == 110 and data[at + 2] == 102:
        return np.inf
    return 0.0


@njit(cache=True, nogil=True)
def digits_of(data: Octets, at: int, end: int) -> tuple[int, int, int]:
    """Digits as one whole number, the power of ten it is to be taken by, and where they end.

    The end is -1 where there are no digits.
    """
    mantissa, digits, seen, power, fraction = 0, 0, 0, 0, False
    while at < end:
        octet = int(data[at])
        if ZERO <= octet <= NINE:
            seen += 1
            if digits < DIGITS:
                mantissa = 10 * mantissa + octet - ZERO
                digits += mantissa > 0
                power -= fraction
            else:
                power += not fraction
        elif octet == POINT and not fraction:
            fraction = True
        else:
            break
        at += 1
    return mantissa, power, at if seen else NO_NUMBER


@njit(cache=True, nogil=True)
def exponent_of(data: Octets, at: int, end: int) -> tuple[int, int]:
    """Exponent behind an e, and where it ends; -1 where there are no digits."""
    falling = at < end and data[at] == MINUS
    if at < end and (data[at] == MINUS or data[at] == PLUS):
        at += 1
    exponent, first = 0, at
    while at < end and ZERO <= data[at] <= NINE:
        exponent = min(10 * exponent + int(data[at]) - ZERO, 9999)
        at += 1
    return -exponent if falling else exponent, at if at > first else NO_NUMBER


@njit(cache=True, nogil=True)
def one_number(data: Octets, at: int, end: int, values: Floats, place: int) -> int:
    """Write the number at `at` into `values[place]`; where it ends, or -1 if it is none.

    To within one unit in the last place of a double of about 16 digits: not the nearest always.
    """
    negative = data[at] == MINUS
    if data[at] == MINUS or data[at] == PLUS:
        at += 1
    if at < end and data[at] > NINE:
        special = word(data, at, end)
        values[place] = -special if negative else special
        return at + 3 if special != 0.0 else NO_NUMBER
    mantissa, power, at = digits_of(data, at, end)
    if 0 <= at < end and (data[at] == EXPONENTS[0] or data[at] == EXPONENTS[1]):
        more, at = exponent_of(data, at + 1, end)
        power += more
    if at >= 0:
        values[place] = scaled(float(mantissa), power, negative)
    return at


@njit(cache=True, nogil=True)
def scaled(number: float, power: int, negative: bool) -> float:
    """Times a power of ten."""
    if number != 0.0:
        while power > 300 and number < np.inf:  # in steps: the power alone is no double
            number, power = number * 1e300, power - 300
        while power < -300 and number > 0.0:
            number, power = number * 1e-300, power + 300
        if abs(power) <= 300:  # else it is infinite, or zero
            number = number * 10.0**power if power > 0 else number / 10.0**-power
    return -number if negative else number


@njit(cache=True, nogil=True)
def vector(data: Octets, at: int, end: int, values: Floats) -> int:
    """Write the numbers of a line into `values`; how many there are, -1 if it has anything else."""
    count = 0
    while at < end:
        octet = int(data[at])
        if octet in (BLANK, TAB, RETURN, COMMA):
            at += 1
            continue
        at = one_number(data, at, end, values, min(count, len(values) - 1))  # all are counted
        if at < 0 or (at < end and data[at] > BLANK and data[at] != COMMA):
            return NO_NUMBER
        count += 1
    return count


@njit(cache=True, nogil=True)
def sequence_of(data: Octets, at: int, end: int) -> int:
    """Number in a stamp ``D 12 1.5``; -1 without one."""
    at += 2
    while at < end and data[at] == BLANK:
        at += 1
    number, first = 0, at
    while at < end and ZERO <= data[at] <= NINE and at - first < DIGITS:
        number = 10 * number + int(data[at]) - ZERO
        at += 1
    return number if at > first else NONE


@njit(cache=True, nogil=True)
def kind_of(values: Floats) -> int:
    """The smallest kind of block that holds all numbers."""
    kind = BYTES
    for value in values:
        if not (0.0 <= value <= 65535.0 and value == np.floor(value)):
            return FLOATS
        if value > 255.0:
            kind = SHORTS
    return kind


@njit(cache=True, nogil=True)
def put_values(
    words: Words,
    octets: Octets,
    shorts: NDArray[np.uint16],
    singles: NDArray[np.float32],
    end: Words,
    stamp_ns: int,
    channel: int,
    values: Floats,
) -> bool:
    """Append a block of all numbers; False if it does not fit."""
    kind = kind_of(values)
    at = begin_block(words, end, stamp_ns, channel, len(values), kind, 0)
    if at < 0:
        return False
    for i in range(len(values)):
        if kind == BYTES:
            octets[at + i] = np.uint8(values[i])
        elif kind == SHORTS:
            shorts[(at >> 1) + i] = np.uint16(values[i])
        else:
            singles[(at >> 2) + i] = values[i]
    return True


@njit(cache=True, nogil=True)
def follow(number: int, state: Ints, counts: Ints) -> None:
    """Count the readings that are missing between two numbers; a smaller one begins anew."""
    if number >= 0:
        if state[SEEN] and number > state[LAST] + 1:
            counts[LOST] += number - state[LAST] - 1
        state[SEEN], state[LAST] = 1, number


@njit(cache=True, nogil=True)
def other_line(letter: int, state: Ints, counts: Ints) -> None:
    """Note a line that begins no vector: a goodbye, an acknowledgement, nothing, or nonsense."""
    if letter == QUIT:
        state[ENDED] = 1
    elif letter not in (RETURN, NEWLINE, ACKNOWLEDGED):
        counts[MALFORMED] += 1


@njit(cache=True, nogil=True)
def take_vectors(
    data: Octets,
    used: int,
    words: Words,
    octets: Octets,
    shorts: NDArray[np.uint16],
    singles: NDArray[np.float32],
    end: Words,
    stamp_ns: int,
    channel: int,
    values: Floats,
    state: Ints,
    counts: Ints,
) -> int:
    """Append the vectors of all complete messages in `data[:used]`; bytes that are done with.

    Parameters
    ----------
    words, octets, shorts, singles, end : arrays
        Of `Blocks`.
    values : (C,) array
        Room for the numbers of one vector; a vector of another length is malformed.
    state : (4,) int64 array
        Whether a number was seen, the last one, whether the other side said goodbye, and the
        length of the last vector if that was another.
    """
    at = 0
    while at < used and not state[ENDED]:
        first = line_end(data, at, used)
        if first >= 0 and data[at] != DATA and data[at] != DATA_ONLY:
            other_line(int(data[at]), state, counts)
            at = first + 1
            continue
        last = line_end(data, first + 1, used) if first >= 0 else NONE
        if last < 0:
            break
        length = vector(data, first + 1, last, values)
        good = length == len(values)
        if good and not put_values(words, octets, shorts, singles, end, stamp_ns, channel, values):
            break
        counts[RECEIVED] += good
        counts[READINGS] += good
        counts[MALFORMED] += not good
        state[LENGTH] = 0 if good else length
        follow(sequence_of(data, at, first), state, counts)
        at = last + 1
    return at

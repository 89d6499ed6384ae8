"""Hash by which rmw_zenoh names everything that takes part: XXH3 of 128 bits, without a seed.

Source: the specification of xxHash (github.com/Cyan4973/xxHash, doc/xxhash_spec.md). Whole numbers
of Python: a name is hashed once.
"""

from struct import unpack_from

from skinfield.errors import InputError

ONES = (1 << 64) - 1
P32_1, P32_2, P32_3 = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
P64_1, P64_2, P64_3 = 0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9
P64_4, P64_5 = 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5
MIX = 0x165667919E3779F9
SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671f"
    "cb79e64eccc0e578825ad07dccff7221b8084674f743248ee03590e6813a264c"
    "3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364"
    "eac5ac8334d3ebc3c581a0fffa1363eb170ddd51b7f0da49d316552629d4689e"
    "2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e"
)
SHORTEST, MIDDLE, LONG = 17, 129, 241  # bytes from which each way is taken
STRIPE, STEP = 64, 8  # bytes of a stripe; of the secret from one to the next
BLOCK = (len(SECRET) - STRIPE) // STEP  # stripes until the sums are scrambled


def gid_of(key: str) -> bytes:
    """The 16 bytes that stand for an entity of ROS 2, of the key of its liveliness token.

    Raises
    ------
    InputError
        If the key has fewer than 17 bytes, which no token has.
    """
    data = key.encode()
    if len(data) < SHORTEST:
        raise InputError(f"key is {key!r}, expected one of at least {SHORTEST} bytes")
    low, high = _long(data) if len(data) >= LONG else _short(data)
    return low.to_bytes(8, "little") + high.to_bytes(8, "little")


def _word(data: bytes, at: int) -> int:
    return int(unpack_from("<Q", data, at)[0])


def _folded(left: int, right: int) -> int:
    product = left * right
    return (product & ONES) ^ (product >> 64)


def _stirred(value: int) -> int:
    value ^= value >> 37
    value = value * MIX & ONES
    return value ^ (value >> 32)


def _mixed(data: bytes, at: int, secret: int) -> int:
    return _folded(
        _word(data, at) ^ _word(SECRET, secret), _word(data, at + 8) ^ _word(SECRET, secret + 8)
    )


def _short(data: bytes) -> tuple[int, int]:
    """Of up to 240 bytes."""
    size = len(data)
    low, high = size * P64_1 & ONES, 0

    def mix(first: int, second: int, secret: int) -> None:
        nonlocal low, high
        low = low + _mixed(data, first, secret) & ONES
        low ^= _word(data, second) + _word(data, second + 8) & ONES
        high = high + _mixed(data, second, secret + 16) & ONES
        high ^= _word(data, first) + _word(data, first + 8) & ONES

    if size < MIDDLE:
        for i in reversed(range((size - 1 >> 5) + 1)):
            mix(16 * i, size - 16 * i - 16, 32 * i)
    else:
        for i in range(4):
            mix(32 * i, 32 * i + 16, 32 * i)
        low, high = _stirred(low), _stirred(high)
        for i in range(4, size >> 5):
            mix(32 * i, 32 * i + 16, 32 * (i - 4) + 3)
        mix(size - 16, size - 32, 103)
    total = low * P64_1 + high * P64_4 + size * P64_2 & ONES
    return _stirred(low + high & ONES), -_stirred(total) & ONES


def _long(data: bytes) -> tuple[int, int]:
    """Of more than 240 bytes: eight sums over stripes."""
    size = len(data)
    sums = [P32_3, P64_1, P64_2, P64_3, P64_4, P32_2, P64_5, P32_1]
    stripes = (size - 1) // STRIPE
    for stripe in range(stripes):
        _add(sums, data, STRIPE * stripe, STEP * (stripe % BLOCK))
        if stripe % BLOCK == BLOCK - 1:
            for lane in range(8):
                value = sums[lane] ^ (sums[lane] >> 47)
                value ^= _word(SECRET, len(SECRET) - STRIPE + 8 * lane)
                sums[lane] = value * P32_1 & ONES
    _add(sums, data, size - STRIPE, len(SECRET) - STRIPE - 7)
    low = _merged(sums, 11, size * P64_1 & ONES)
    return low, _merged(sums, len(SECRET) - STRIPE - 11, ~(size * P64_2) & ONES)


def _add(sums: list[int], data: bytes, at: int, secret: int) -> None:
    for lane in range(8):
        value = _word(data, at + 8 * lane)
        key = value ^ _word(SECRET, secret + 8 * lane)
        sums[lane ^ 1] = sums[lane ^ 1] + value & ONES
        sums[lane] = sums[lane] + (key & 0xFFFFFFFF) * (key >> 32) & ONES


def _merged(sums: list[int], secret: int, total: int) -> int:
    for i in range(4):
        at = secret + 16 * i
        total += _folded(sums[2 * i] ^ _word(SECRET, at), sums[2 * i + 1] ^ _word(SECRET, at + 8))
    return _stirred(total & ONES)

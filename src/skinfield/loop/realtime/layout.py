"""Layout of a histogram of times: where in an array which number stands."""

OCTAVE_BITS = 6  # 64 bins per power of two: a bin is at most 1/64 of its times wide
TOP = (1 << 34) - 1  # ns: the last bin ends with it, 17.2 s
BINS = (28 << OCTAVE_BITS) + (1 << OCTAVE_BITS)
LONGEST = BINS  # word of the longest time, ns, exact
SUM = BINS + 1  # word of the sum of all times, ns, exact
WORDS = BINS + 2

CYCLES, LATE, OVERRUN, SKIPPED = range(4)  # words of what an engine counts beside its times

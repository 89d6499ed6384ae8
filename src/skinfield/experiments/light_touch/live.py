"""Live readings: how soon after it began a touch is seen."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.detection import DetectorStream
from skinfield.errors import Floats
from skinfield.experiments.light_touch.trials import LOOKED, Touch, clean, detector, noise_of
from skinfield.experiments.settings import Settings

BEFORE, AFTER = LOOKED - 1, 2 * LOOKED  # readings around the moment of touch
TRIALS = {"smoke": 12, "short": 300, "full": 2000}
CHUNK = 50  # touches at once
SHARE = 4  # idle readings of the settings, per idle window of a stream


@dataclass(frozen=True, eq=False)
class Live:
    """Shares (N,) of touches seen by the time of each reading since touch.

    Attributes
    ----------
    touch : Touch
    now : (N,) array
        Seen at this very reading.
    once : (N,) array
        Seen at this reading or one before it, since the touch.
    trials : int
    """

    touch: Touch
    now: Floats
    once: Floats
    trials: int


@lru_cache(maxsize=4)
def _stream(settings: Settings, quantity: str) -> DetectorStream:
    return detector(settings, quantity, False).stream(LOOKED / settings.rate, settings.rate)


def watched(touch: Touch, settings: Settings, seed: int) -> Live:
    """Look back with every reading, over touches that begin after `BEFORE` idle ones."""
    count = TRIALS[settings.size.name]
    stream = _stream(settings, touch.quantity)
    pressed = clean(touch, settings, count, seed)
    rng = np.random.default_rng([settings.seed, 43, seed])
    scale = noise_of(settings, touch.quantity)
    seen = []
    for first in range(0, count, CHUNK):
        part = pressed[first : first + CHUNK]
        noise = rng.normal(scale=scale, size=(len(part), BEFORE + AFTER, part.shape[1]))
        noise[:, BEFORE:] += part[:, None]
        seen.append(_seen(stream, noise))
    table = np.concatenate(seen)
    once = np.logical_or.accumulate(table, axis=1).mean(axis=0)
    return Live(touch, table.mean(axis=0), once, count)


def idle_alarms(settings: Settings, quantity: str) -> tuple[int, int]:
    """Alarms, and of how many windows of an idle patch; windows that do not overlap."""
    stream, count = _stream(settings, quantity), settings.size.quiet // SHARE
    rng = np.random.default_rng([settings.seed, 44])
    scale, taxels = noise_of(settings, quantity), len(stream.detector.patch)
    alarms = 0
    for first in range(0, count, CHUNK):
        shape = (min(CHUNK, count - first), stream.lengths[-1], taxels)
        alarms += int(_seen(stream, rng.normal(scale=scale, size=shape)).sum())
    return alarms, count


def _seen(stream: DetectorStream, readings: Floats) -> Floats:
    """What `DetectorStream.update` says of N series (N, T, L) from the first full window on."""
    whitened = stream.lookback.bank.whitened(readings)
    start = np.zeros_like(whitened[:, :1])
    total = np.concatenate([start, whitened.cumsum(axis=1)], axis=1)
    longest = stream.lengths[-1]
    columns = []
    for end in range(longest, total.shape[1]):
        sums = np.stack([total[:, end] - total[:, end - n] for n in stream.lengths], axis=1)
        statistic = stream.detector.statistic(stream.lookback.matches(sums))
        columns.append(statistic > stream.threshold)
    return np.stack(columns, axis=1)

"""Multi-target tracking, compiled: Kalman filters, optimal assignment, merging, splitting, slip.

Nothing is allocated. One function is called per reading of a patch, see `track`.
"""

from typing import Any

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.estimate.track_memory import (
    EVENTS,
    FLOORS,
    FREE,
    LISTED,
    MATCH,
    NOW,
    ORIGIN,
    PAIR,
    STARTED,
    TOP,
    USED,
    WAY,
    TrackMemory,
)

NS = 1e-9
MADE, MOVED, MERGED, SPLIT, LOST = range(5)  # as `tracked.KINDS`
GONE = -2  # parent that is no more
TIE, TIE_PLACE = 1e-9, 1e-9  # forces that differ by this part are equal, and so are places, m
TIE_DISTANCE = 1e-4  # m
TENTATIVE = 3.0  # added to the cost of a track that is not confirmed yet
FORCE_COST = 9.0  # most that a force which does not fit adds to the cost
FORCE_FLOOR = 0.15  # part of a force: what solvers do not state of it
LIMIT = 21.1  # squared distance of three numbers that is exceeded with a chance of 1e-4
NARROW = 3e-3  # m: bodies whose ways come nearer than this cannot pass each other
NEWTON = 1e-9  # N: least force that has a share


@njit
def track(memory: TrackMemory, rules: Any, ids: Ints, count: int, now: int) -> None:
    """Go on to a reading with `count` contacts, which are in `memory.value` and `memory.noise`.

    Afterwards `column` of each track is the place of its contact there, -1 where it coasts. The
    order of contacts does not matter: they are sorted here.

    Parameters
    ----------
    memory : TrackMemory
        With room for `count` contacts.
    rules : (1,) array of RULES
    ids : (1,) int array
        The last number of a contact, which may be shared between patches.
    now : int, ns
        Stamp of the reading. Where it is before that of the last one, the clock was set back, and
        no time has passed.
    """
    rule, words, lists, tracks = rules[0], memory.words, memory.lists, memory.tracks
    passed = now - words[NOW] if words[STARTED] else 0
    words[NOW], words[STARTED] = now, 1
    if passed < 0:
        shift_times(memory, passed)
    elif passed > max(rule.memory_ns, rule.period_ns):  # nobody knows what happened between
        for place in range(words[TOP]):
            lose(memory, place)
    sort_contacts(memory.value, memory.noise, lists[ORIGIN], count)
    step = NS * max(passed, 0)
    for place in range(words[TOP]):
        lists[PAIR, place] = -1
        if tracks[place].alive:
            predict(tracks[place], rule, step)
    for place in range(len(memory.absorbed)):
        if now - memory.absorbed[place].time > rule.memory_ns:
            memory.absorbed[place].owner = -1
    for column in range(count):
        lists[FREE, column] = 1
    if count > 0 and words[TOP] > 0:
        assign(memory, rule, count)
    merge_tracks(memory, rule, count)
    split_tracks(memory, rule, ids, count)
    for place in range(words[TOP]):
        if tracks[place].alive and lists[PAIR, place] >= 0:
            update(memory, rule, place, lists[PAIR, place])
    for column in range(count):
        if lists[FREE, column]:
            add_track(memory, rule, ids, column)
    drop_unseen(memory, rule)
    for place in range(words[TOP]):
        if tracks[place].alive and not tracks[place].confirmed:
            confirm(memory, rule, place)
    top = 0
    for place in range(words[TOP]):
        if tracks[place].alive:
            top = place + 1
            if tracks[place].column >= 0:
                if tracks[place].confirmed:
                    watch_slip(memory, rule, place)
                tracks[place].column = lists[ORIGIN, tracks[place].column]
    words[TOP] = top


@njit
def begin_from(memory: TrackMemory, rules: Any, many: int, now: int, rows: Any) -> None:
    """Know of the contacts that the first `many` rows state at `now` ns, and of nothing else.

    Of their speed nothing is taken over; those of their first reading are confirmed if strong.
    """
    measure_rows(memory, rules[0], many, rows)
    words = memory.words
    words[NOW], words[STARTED], words[TOP] = now, 1, many
    for row in range(many):
        passed = int(np.rint(rows[row].age / NS))
        begin_track(memory, rules[0], row, row, rows[row].track, now - passed)
        memory.tracks[row].confirmed = passed > 0 or is_strong(memory, rules[0], row)


@inner
def number_rows(memory: TrackMemory, rules: Any, ids: Ints, many: int, now: int, rows: Any) -> None:
    """Go on to a reading whose contacts are the first `many` rows, and write what is known of them.

    Rows are of `CONTACT`.
    """
    measure_rows(memory, rules[0], many, rows)
    track(memory, rules, ids, many, now)
    for place in range(memory.words[TOP]):
        known = memory.tracks[place]
        if known.alive and known.column >= 0:
            row, mean = rows[known.column], known.mean
            row.track, row.age = known.number, NS * (now - known.made)
            row.speed = np.hypot(mean[3], mean[4])


@inner
def measure_rows(memory: TrackMemory, rule: Any, many: int, rows: Any) -> None:
    """Write rows as contacts of a reading.

    A standard deviation that is not known is taken from the gate's floor and `FORCE_FLOOR`.
    """
    for row in range(many):
        force, place_std, force_std = (
            rows[row].normal_force,
            rows[row].place_std,
            rows[row].force_std,
        )
        place_std = place_std if np.isfinite(place_std) else rule.floor
        force_std = force_std if np.isfinite(force_std) else FORCE_FLOOR * force
        memory.value[row, 0], memory.value[row, 1] = rows[row].x, rows[row].y
        memory.value[row, 2] = force
        for i in range(3):
            for j in range(3):
                memory.noise[row, i, j] = FLOORS[i, j]
            memory.noise[row, i, i] += place_std**2 if i < 2 else force_std**2


@inner
def shift_times(memory: TrackMemory, by: int) -> None:
    """Set the times of all tracks back, ns."""
    for place in range(memory.words[TOP]):
        known = memory.tracks[place]
        known.made, known.slipped = known.made + by, known.slipped + by
        known.last += by
    for place in range(len(memory.absorbed)):
        one = memory.absorbed[place]
        one.made, one.slipped, one.time = one.made + by, one.slipped + by, one.time + by


@inner
def sort_contacts(value: Floats, noise: Floats, origin: Ints, count: int) -> None:
    """Sort by falling force; of equal ones by rising x, then y."""
    for column in range(count):
        origin[column] = column
        place = column
        while place > 0 and comes_before(value[place], value[place - 1]):
            origin[place], origin[place - 1] = origin[place - 1], origin[place]
            for i in range(3):
                value[place, i], value[place - 1, i] = value[place - 1, i], value[place, i]
                for j in range(3):
                    one, other = noise[place, i, j], noise[place - 1, i, j]
                    noise[place, i, j], noise[place - 1, i, j] = other, one
            place -= 1


@inner
def comes_before(one: Floats, other: Floats) -> bool:
    """Whether a contact (3,) comes before another one."""
    if abs(one[2] - other[2]) > TIE * abs(other[2]):
        return bool(one[2] > other[2])
    if abs(one[0] - other[0]) > TIE_PLACE:
        return bool(one[0] < other[0])
    return bool(one[1] < other[1] - TIE_PLACE)


@inner
def predict(known: Any, rule: Any, step: float) -> None:
    """Carry a track on by `step` s; a force does not become a pull.

    The rates are driven by white noise: Bar-Shalom, Li and Kirubarajan 2001, section 6.2.2.
    """
    mean, covariance = known.mean, known.covariance
    known.column = -1
    for i in range(3):
        mean[i] += step * mean[i + 3]
        for j in range(3):
            both = covariance[i, j + 3] + covariance[i + 3, j] + step * covariance[i + 3, j + 3]
            covariance[i, j] += step * both
    for i in range(3):
        for j in range(3):
            covariance[i, j + 3] += step * covariance[i + 3, j + 3]
            covariance[j + 3, i] = covariance[i, j + 3]
    push(covariance, rule.place_push, rule.force_push, step**3 / 3, step**2 / 2, step)
    if mean[2] < 0.0:
        mean[2] = mean[5] = 0.0


@inner
def push(
    covariance: Floats, by_place: float, by_force: float, place: float, both: float, rate: float
) -> None:
    """Add multiples of two variances to those of place and force, and of their rates."""
    for i in range(3):
        variance = by_place if i < 2 else by_force
        covariance[i, i] += place * variance
        covariance[i, i + 3] += both * variance
        covariance[i + 3, i] += both * variance
        covariance[i + 3, i + 3] += rate * variance


@inner
def update(memory: TrackMemory, rule: Any, place: int, column: int) -> None:
    """Take up a contact.

    Where that is a surprise, the rates may have changed at once when the track was seen last.
    """
    known, value, noise = memory.tracks[place], memory.value[column], memory.noise[column]
    mean, covariance, gain = known.mean, known.covariance, memory.work
    off = (value[0] - mean[0], value[1] - mean[1], value[2] - mean[2])
    parts = decomposed(covariance, noise, 0.0, 0.0)
    if square(parts, off) > rule.surprise:
        since = NS * (memory.words[NOW] - known.last)
        variances = rule.speed_variance, rule.force_rate_variance
        push(covariance, *variances, since**2, since, 1.0)
        parts = decomposed(covariance, noise, 0.0, 0.0)
    for i in range(6):
        row = solved(parts, (covariance[i, 0], covariance[i, 1], covariance[i, 2]))
        for k in range(3):
            gain[k, i] = row[k]
            gain[3 + k, i] = covariance[k, i]
    for i in range(6):
        mean[i] += gain[0, i] * off[0] + gain[1, i] * off[1] + gain[2, i] * off[2]
        for j in range(i + 1):
            one, other = 0.0, 0.0
            for k in range(3):
                one += gain[k, i] * gain[3 + k, j]
                other += gain[k, j] * gain[3 + k, i]
            left = 0.5 * (covariance[i, j] + covariance[j, i] - one - other)
            covariance[i, j] = covariance[j, i] = left
    speed = np.hypot(mean[3], mean[4])
    if speed > rule.top_speed:
        mean[3] *= rule.top_speed / speed
        mean[4] *= rule.top_speed / speed
    saw(memory, place, column)


@inner
def saw(memory: TrackMemory, place: int, column: int) -> None:
    """A contact of this reading belongs to a track."""
    known = memory.tracks[place]
    known.last, known.column, known.readings = memory.words[NOW], column, known.readings + 1
    memory.lists[PAIR, place], memory.lists[FREE, column] = -1, 0


@inner
def restart(
    memory: TrackMemory, rule: Any, place: int, column: int, rates: tuple[float, float, float]
) -> None:
    """Begin anew at a contact, with rates of which little is known."""
    known = memory.tracks[place]
    mean, covariance = known.mean, known.covariance
    for i in range(6):
        for j in range(6):
            covariance[i, j] = 0.0
    for i in range(3):
        mean[i], mean[i + 3] = memory.value[column, i], rates[i]
        for j in range(3):
            covariance[i, j] = memory.noise[column, i, j]
        variance = rule.speed_variance if i < 2 else rule.force_rate_variance
        covariance[i + 3, i + 3] = variance
    saw(memory, place, column)


@inner
def add_track(memory: TrackMemory, rule: Any, ids: Ints, column: int) -> int:
    """Begin a track; in place of none, else of the one not seen for longest. Its place."""
    tracks, words, place = memory.tracks, memory.words, -1
    for each in range(len(tracks)):
        if each >= words[TOP] or not tracks[each].alive:
            place = each
            break
    if place < 0:
        for each in range(len(tracks)):
            unseen = tracks[each].column < 0 and memory.lists[PAIR, each] < 0
            if unseen and (place < 0 or tracks[each].last < tracks[place].last):
                place = each
        lose(memory, place)
    words[TOP] = max(words[TOP], place + 1)
    ids[0] += 1
    begin_track(memory, rule, place, column, ids[0], words[NOW])
    return place


@inner
def begin_track(
    memory: TrackMemory, rule: Any, place: int, column: int, number: int, made: int
) -> None:
    """Begin a track at a contact, which was made at `made` ns."""
    known = memory.tracks[place]
    known.number, known.made, known.slipped, known.slips = number, made, made, 0
    known.alive, known.confirmed, known.parent, known.readings = 1, 0, -1, 0
    restart(memory, rule, place, column, (0.0, 0.0, 0.0))


@inner
def end_track(memory: TrackMemory, place: int, heir: int) -> None:
    """End a track; what it had absorbed goes to an heir, -1: to none."""
    memory.tracks[place].alive, memory.lists[PAIR, place] = 0, -1
    for other in range(memory.words[TOP]):
        if memory.tracks[other].parent == place:
            memory.tracks[other].parent = GONE
    for one in range(len(memory.absorbed)):
        if memory.absorbed[one].owner == place:
            memory.absorbed[one].owner = heir


@inner
def lose(memory: TrackMemory, place: int) -> None:
    """End a track of which nothing is seen."""
    if memory.tracks[place].alive:
        if memory.tracks[place].confirmed:
            report(memory, LOST, place, -1)
        end_track(memory, place, -1)


@inner
def report(memory: TrackMemory, kind: int, place: int, other: int) -> None:
    """Write an event of a track, and of another number."""
    words, known = memory.words, memory.tracks[place]
    event = memory.events[words[EVENTS] % len(memory.events)]
    ids, mean = event.ids, known.mean
    event.kind, event.time, event.x, event.y = kind, words[NOW], mean[0], mean[1]
    ids[0], ids[1] = known.number, other
    words[EVENTS] += 1


@inner
def decomposed(
    one: Floats, other: Floats, floor: float, force: float
) -> tuple[float, float, float, float, float, float]:
    """Factors L D L' of the sum of two covariances, and of two variances: D, and L's 10, 20, 21."""
    first = one[0, 0] + other[0, 0] + floor
    xy, xf = one[0, 1] + other[0, 1], one[0, 2] + other[0, 2]
    a, b = xy / first, xf / first
    second = one[1, 1] + other[1, 1] + floor - a * xy
    yf = one[1, 2] + other[1, 2] - a * xf
    c = yf / second
    third = one[2, 2] + other[2, 2] + force - b * xf - c * yf
    return first, second, third, a, b, c


@inner
def square(
    parts: tuple[float, float, float, float, float, float], off: tuple[float, float, float]
) -> float:
    """Squared Mahalanobis distance."""
    second = off[1] - parts[3] * off[0]
    third = off[2] - parts[4] * off[0] - parts[5] * second
    return off[0] ** 2 / parts[0] + second**2 / parts[1] + third**2 / parts[2]


@inner
def solved(
    parts: tuple[float, float, float, float, float, float], row: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Inverse of what was decomposed, times a row."""
    second = row[1] - parts[3] * row[0]
    third = (row[2] - parts[4] * row[0] - parts[5] * second) / parts[2]
    second = second / parts[1] - parts[5] * third
    return row[0] / parts[0] - parts[3] * second - parts[4] * third, second, third


@inner
def assign(memory: TrackMemory, rule: Any, count: int) -> None:
    """Write which contact goes on with which track, so that the sum of the gains is the highest.

    A pair costs the squared Mahalanobis distance of the place and, up to a limit, that of the
    force, and the logarithm of the place's variance: of two as near, the surer one goes on.
    """
    listed, gains, work, lists = memory.lists[LISTED], memory.gains, memory.work, memory.lists
    many = 0
    for place in range(memory.words[TOP]):
        if memory.tracks[place].alive:
            listed[many] = place
            many += 1
    turned = many > count
    rows, columns = (count, many) if turned else (many, count)
    for row in range(rows):
        for column in range(columns):
            index, contact = (column, row) if turned else (row, column)
            known = memory.tracks[listed[index]]
            gains[row, column] = gain_of(known, memory.value[contact], memory.noise[contact], rule)
    match = lists[MATCH]
    pair_best(gains, rows, columns, work, match, lists[WAY], lists[USED])
    for column in range(1, columns + 1):
        row = match[column]
        if row > 0 and gains[row - 1, column - 1] > 0.0:
            index, contact = (column, row) if turned else (row, column)
            lists[PAIR, listed[index - 1]], lists[FREE, contact - 1] = contact - 1, 0


@inner
def pair_best(
    gains: Floats, rows: int, columns: int, work: Floats, match: Ints, way: Ints, used: Ints
) -> None:
    """Write into `match` which row, counted from 1, goes with column 1, 2, ... (0: none).

    The sum of the gains is the highest there is: by shortest augmenting paths (Jonker and Volgenant
    1987) from each row, of which there are no more than columns.
    """
    by_row, by_column, least = work[0], work[1], work[2]
    for column in range(columns + 1):
        by_row[min(column, rows)], by_column[column], match[column] = 0.0, 0.0, 0
    for row in range(1, rows + 1):
        match[0], here = row, 0
        for column in range(columns + 1):
            least[column], used[column] = np.inf, 0
        while match[here] > 0:
            used[here], step, nearest = 1, np.inf, 0
            for column in range(1, columns + 1):
                if not used[column]:
                    cost = -gains[match[here] - 1, column - 1]
                    cost -= by_row[match[here]] + by_column[column]
                    if cost < least[column]:
                        least[column], way[column] = cost, here
                    if least[column] < step:
                        step, nearest = least[column], column
            for column in range(columns + 1):
                if used[column]:
                    by_row[match[column]] += step
                    by_column[column] -= step
                else:
                    least[column] -= step
            here = nearest
        while here > 0:
            match[here] = match[way[here]]
            here = way[here]


@inner
def gain_of(known: Any, value: Floats, noise: Floats, rule: Any) -> float:
    """What a pair of a track and a contact is worth; 0 beyond the gate."""
    mean, covariance = known.mean, known.covariance
    x, y, force = value[0] - mean[0], value[1] - mean[1], value[2] - mean[2]
    if np.hypot(x, y) > rule.reach:
        return 0.0
    floor = rule.floor**2
    a, c = covariance[0, 0] + noise[0, 0] + floor, covariance[1, 1] + noise[1, 1] + floor
    b = covariance[0, 1] + noise[0, 1]
    area = a * c - b * b
    distance = (c * x * x - 2 * b * x * y + a * y * y) / area
    if distance > rule.gate:
        return 0.0
    gain = rule.gate + FORCE_COST + TENTATIVE - distance - np.log(area / floor**2)
    gain -= min(force * force / (covariance[2, 2] + noise[2, 2]), FORCE_COST)
    return float(max(gain if known.confirmed else gain - TENTATIVE, 0.0))


@inner
def misfit(
    one: Floats, covariance: Floats, other: Floats, noise: Floats, floor: float
) -> tuple[float, float]:
    """Squared distance of two loads, and twice the negative logarithm of its density.

    `floor` m is added to the standard deviation of the place, and a share of the force to its own.
    """
    force = FORCE_FLOOR * max(one[2], other[2])
    parts = decomposed(covariance, noise, floor**2, force**2)
    distance = square(parts, (one[0] - other[0], one[1] - other[1], one[2] - other[2]))
    return distance, distance + np.log(parts[0] * parts[1] * parts[2])


@inner
def add_loads(
    one: Floats, covariance: Floats, other: Floats, noise: Floats, work: Floats
) -> tuple[Floats, Floats]:
    """Sum (3,) of two loads at their centre, with its covariance to first order, in `work`."""
    # a force below its own uncertainty says nothing of where the centre is
    mine, its = max(one[2], np.sqrt(covariance[2, 2])), max(other[2], np.sqrt(noise[2, 2]))
    share, rest = mine / (mine + its), its / (mine + its)
    value, spread = work[3], work[4:7]
    x, y = (one[0] - other[0]) / (mine + its), (one[1] - other[1]) / (mine + its)
    value[0], value[1] = share * one[0] + rest * other[0], share * one[1] + rest * other[1]
    value[2] = one[2] + other[2]
    for i in range(3):
        for j in range(3):
            spread[i, j] = 0.0
    for part in range(2):
        its_own = covariance if part == 0 else noise
        s, u, v = (share, x * rest, y * rest) if part == 0 else (rest, -x * share, -y * share)
        xf, yf, ff = its_own[0, 2], its_own[1, 2], its_own[2, 2]
        spread[0, 0] += s * s * its_own[0, 0] + 2 * s * u * xf + u * u * ff
        spread[1, 1] += s * s * its_own[1, 1] + 2 * s * v * yf + v * v * ff
        spread[0, 1] += s * s * its_own[0, 1] + s * v * xf + s * u * yf + u * v * ff
        spread[0, 2] += s * xf + u * ff
        spread[1, 2] += s * yf + v * ff
        spread[2, 2] += ff
    return value, spread


@inner
def distance_of(one: Floats, other: Floats) -> float:
    """Of two loads, m."""
    return float(np.hypot(one[0] - other[0], one[1] - other[1]))


@inner
def is_open(known: Any) -> bool:
    """Whether a track is confirmed, and did not begin anew in this step."""
    return bool(known.alive and known.confirmed and known.column < 0)


@inner
def merge_tracks(memory: TrackMemory, rule: Any, count: int) -> None:
    """Merge tracks that are not seen, but whose force is in another's contact."""
    tracks, lists = memory.tracks, memory.lists
    for goes in range(memory.words[TOP]):
        if not is_open(tracks[goes]) or lists[PAIR, goes] >= 0:
            continue
        best, other, contact = np.inf, -1, -1
        for stays in range(memory.words[TOP]):
            if stays == goes or not is_open(tracks[stays]):
                continue
            for column in range(count):
                pair = lists[PAIR, stays]
                if column == pair or (pair < 0 and lists[FREE, column]):
                    score = merged_score(memory, rule, tracks[stays], tracks[goes], column)
                    if score < best:
                        best, other, contact = score, stays, column
        if other >= 0:
            absorb(memory, rule, goes, other, contact)


@inner
def merged_score(memory: TrackMemory, rule: Any, stays: Any, goes: Any, column: int) -> float:
    """How badly a contact fits both tracks as one contact; infinite if it is not that.

    Either one of them may go on alone: then the contact fits it better than both.
    """
    one, covariance, other, its = stays.mean, stays.covariance, goes.mean, goes.covariance
    value, noise, floor = memory.value[column], memory.noise[column], rule.floor
    if distance_of(one, other) > rule.near:
        return float(np.inf)
    both, spread = add_loads(one, covariance, other, its, memory.work)
    distance, score = misfit(both, spread, value, noise, floor)
    alone = misfit(one, covariance, value, noise, floor)[1]
    alone = min(alone, misfit(other, its, value, noise, floor)[1])
    return score if distance < LIMIT and score < alone else float(np.inf)


@inner
def absorb(memory: TrackMemory, rule: Any, one: int, other: int, column: int) -> None:
    """Merge two tracks: the stronger has the number, and begins anew where both are seen."""
    tracks, absorbed = memory.tracks, memory.absorbed
    is_one = tracks[one].mean[2] > tracks[other].mean[2]
    place, ends = (one, other) if is_one else (other, one)
    stays, goes = tracks[place], tracks[ends]
    end_track(memory, ends, place)
    free = 0
    for each in range(len(absorbed)):
        if absorbed[each].owner < 0:
            free = each
            break
        if absorbed[each].time < absorbed[free].time:
            free = each
    past, apart, forces, variances = (
        absorbed[free],
        absorbed[free].apart,
        absorbed[free].forces,
        absorbed[free].variances,
    )
    past.owner, past.time = place, memory.words[NOW]
    exchange(past, goes)
    mean, its, covariance, its_covariance = stays.mean, goes.mean, stays.covariance, goes.covariance
    for i in range(6):
        apart[i] = its[i] - mean[i]
    forces[0], forces[1] = its[2], mean[2]
    for i in range(2):
        variances[i] = 0.0
        for k in range(3 * i, 3 * i + 2):
            variances[i] += 0.5 * (covariance[k, k] + its_covariance[k, k])
    mine, others = max(mean[2], NEWTON), max(its[2], NEWTON)
    x, y = mine * mean[3] + others * its[3], mine * mean[4] + others * its[4]
    restart(memory, rule, place, column, (x / (mine + others), y / (mine + others), 0.0))
    report(memory, MERGED, place, past.number)


@inner
def exchange(one: Any, other: Any) -> None:
    """Exchange two identities."""
    one.number, other.number = other.number, one.number
    one.made, other.made = other.made, one.made
    one.slipped, other.slipped = other.slipped, one.slipped
    one.slips, other.slips = other.slips, one.slips


@inner
def split_tracks(memory: TrackMemory, rule: Any, ids: Ints, count: int) -> None:
    """Split tracks whose force is in a contact without a track."""
    lists, tracks = memory.lists, memory.tracks
    for column in range(count):
        if not lists[FREE, column]:
            continue
        best, whole, other = np.inf, -1, -1
        for place in range(memory.words[TOP]):
            if not is_open(tracks[place]):
                continue
            for half in range(count):
                pair = lists[PAIR, place]
                if half == pair or (pair < 0 and lists[FREE, half] and half != column):
                    score = split_score(memory, rule, place, half, column)
                    if score < best:
                        best, whole, other = score, place, half
        if whole >= 0:
            divide(memory, rule, ids, whole, other, column)


@inner
def newest_absorbed(memory: TrackMemory, place: int) -> int:
    """Place of what a track absorbed last; -1: nothing."""
    newest, absorbed = -1, memory.absorbed
    for one in range(len(absorbed)):
        if absorbed[one].owner == place and (
            newest < 0 or absorbed[one].time > absorbed[newest].time
        ):
            newest = one
    return newest


@inner
def split_score(memory: TrackMemory, rule: Any, whole: int, half: int, other: int) -> float:
    """How badly two contacts fit one track; infinite if one of them is a contact by itself.

    Of a track that absorbed another shortly before, two contacts nearby are taken for both.
    """
    mean, covariance = memory.tracks[whole].mean, memory.tracks[whole].covariance
    one, its, noise, its_noise = (
        memory.value[half],
        memory.value[other],
        memory.noise[half],
        memory.noise[other],
    )
    if max(distance_of(mean, one), distance_of(mean, its)) > rule.near:
        return float(np.inf)
    both, spread = add_loads(one, noise, its, its_noise, memory.work)
    distance, score = misfit(mean, covariance, both, spread, rule.floor)
    if newest_absorbed(memory, whole) >= 0:
        return score
    if distance_of(one, its) > rule.near:
        return float(np.inf)
    alone = misfit(mean, covariance, one, noise, rule.floor)[1]
    alone = min(alone, misfit(mean, covariance, its, its_noise, rule.floor)[1])
    return score if distance < LIMIT and score < alone else float(np.inf)


@inner
def divide(memory: TrackMemory, rule: Any, ids: Ints, whole: int, half: int, other: int) -> None:
    """Split a track: the contact that it had goes on, else the nearer; if as near, the stronger."""
    mean, swap = memory.tracks[whole].mean, False
    if memory.lists[PAIR, whole] != half:
        away = distance_of(mean, memory.value[half]) - distance_of(mean, memory.value[other])
        swap = away > TIE_DISTANCE or (abs(away) <= TIE_DISTANCE and other < half)
    near, far = (other, half) if swap else (half, other)
    restart(memory, rule, whole, near, (mean[3], mean[4], mean[5]))
    child = add_track(memory, rule, ids, far)
    memory.tracks[child].parent = whole


@inner
def drop_unseen(memory: TrackMemory, rule: Any) -> None:
    """Lose tracks that coasted for too long, and unconfirmed ones at once."""
    for place in range(memory.words[TOP]):
        known = memory.tracks[place]
        unseen = memory.words[NOW] - known.last
        if known.alive and known.column < 0 and (not known.confirmed or unseen > rule.coast_ns):
            lose(memory, place)


@inner
def confirm(memory: TrackMemory, rule: Any, place: int) -> None:
    """Confirm a strong contact; a weak one, and a part of another, after some readings."""
    known = memory.tracks[place]
    strong = known.parent == -1 and is_strong(memory, rule, place)
    if not strong and known.readings < rule.weak_readings:
        return
    parent, known.parent, known.confirmed = known.parent, -1, 1
    if parent < 0 or not memory.tracks[parent].confirmed:
        report(memory, MADE, place, -1)
        return
    newest = newest_absorbed(memory, parent)
    if newest >= 0:
        past = memory.absorbed[newest]
        past.owner = -1
        exchange(past, known)
        if is_exchanged(memory, rule, past, parent, place):
            exchange(memory.tracks[parent], known)
    report(memory, SPLIT, parent, known.number)


@inner
def is_strong(memory: TrackMemory, rule: Any, place: int) -> bool:
    """Whether the force of a track's contact is beyond doubt."""
    column = memory.tracks[place].column
    return bool(memory.value[column, 2] >= rule.strong * np.sqrt(memory.noise[column, 2, 2]))


@inner
def is_exchanged(memory: TrackMemory, rule: Any, past: Any, parent: int, place: int) -> bool:
    """Whether after a split the new track is what had stayed, and the other one came back.

    The distance of both is carried on from when they merged. Solid bodies do not pass through each
    other: those whose ways would have met turned back, and kept their sides.
    """
    mean, its = memory.tracks[parent].mean, memory.tracks[place].mean
    apart, forces, variances = past.apart, past.forces, past.variances
    span = NS * (memory.words[NOW] - past.time)
    across = apart[0] * apart[4] - apart[1] * apart[3]
    clear = abs(across) > NARROW * np.hypot(apart[3], apart[4])
    carried = span if clear else 0.0
    x, y = apart[0] + carried * apart[3], apart[1] + carried * apart[4]
    variance = variances[0] + span**2 * variances[1] + 2 * rule.place_push * span**3 / 3
    favour = 2.0 * ((its[0] - mean[0]) * x + (its[1] - mean[1]) * y) / (variance + rule.floor**2)
    unsure = (FORCE_FLOOR * (forces[0] + forces[1])) ** 2 + rule.force_push * span**3 / 3
    unsure += memory.tracks[place].covariance[2, 2] + memory.tracks[parent].covariance[2, 2]
    favour += (its[2] - mean[2]) * (forces[0] - forces[1]) / unsure
    return bool(favour < 0.0)


@inner
def watch_slip(memory: TrackMemory, rule: Any, place: int) -> None:
    """Say whether a place moves: by its speed, beyond doubt, or as it has hardly slowed."""
    known = memory.tracks[place]
    x, y, covariance = known.mean[3], known.mean[4], known.covariance
    speed, slipped = np.hypot(x, y), known.slips
    known.slips = 0
    if speed > rule.slip_speed:
        variance = covariance[3, 3] * x * x + covariance[4, 4] * y * y
        std = np.sqrt(variance + 2.0 * covariance[3, 4] * x * y) / speed
        known.slips = speed - (1.0 if slipped else rule.slip_sigmas) * std > rule.slip_speed
    if known.slips:
        known.slipped = memory.words[NOW]
        if not slipped:
            report(memory, MOVED, place, -1)

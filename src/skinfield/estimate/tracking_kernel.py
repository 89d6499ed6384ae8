"""Multi-target tracking, compiled: Kalman filters, optimal assignment, merging, splitting, slip.

Nothing is allocated. One function is called per reading of a patch, see `track`.
"""

from typing import Any

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.estimate.mahalanobis_kernel import Three, chance_beyond, factors, square, whitened
from skinfield.estimate.track_memory import (
    ABSORBED,
    CONFIRMED,
    EVENTS,
    FREE,
    NOW,
    STARTED,
    TENTATIVE,
    TOP,
    TrackMemory,
)

NS = 1e-9
MADE, MOVED, MERGED, SPLIT, LOST = range(5)  # as `tracked.KINDS`
GONE = -2  # parent that is no more
TIE, TIE_PLACE, TIE_DISTANCE = 1e-9, 1e-9, 1e-4  # equal forces: part of them; places, ways: m
HANDICAP = 3.0  # added to the cost of a track that is not confirmed yet
FORCE_COST = 9.0  # most that a force which does not fit adds to the cost
FORCE_FLOOR = 0.15  # part of a force: what solvers do not state of it
LIMIT = 21.1  # squared distance of three numbers that is exceeded with a chance of 1e-4
NARROW = 3e-3  # m: bodies whose ways come nearer than this cannot pass each other
ALIKE = 0.5  # part of a force by which it may differ after a pause
LEAST = 1e-9  # N that has a share


@njit
def track(memory: TrackMemory, count: int, now: int) -> None:
    """Go on to a reading with `count` contacts, which are in `memory.contacts`, at `now` ns.

    Afterwards `column` of each track is the place of its contact there, -1 where it coasts. The
    order of contacts does not matter: they are sorted here. After a pause of readings tracks go on
    where they were, see `Tracker.pause`. Where a clock was set back by less than the memory, no
    time passes until it has caught up.
    """
    rule, words, tracks, contacts = memory.rules[0], memory.words, memory.tracks, memory.contacts
    passed = now - words[NOW] if words[STARTED] else 0
    lasts = max(rule.memory_ns, rule.period_ns)
    paused = lasts < passed <= rule.pause_ns
    forgets = abs(passed) > lasts and not paused
    words[NOW] = now if forgets or not words[STARTED] else max(now, words[NOW])
    words[STARTED] = 1
    if forgets:  # nobody knows what happened between
        for place in range(words[TOP]):
            end_track(memory, place, -1)
    sort_contacts(contacts, count)
    for place in range(words[TOP]):
        known = tracks[place]
        known.pair = known.column = -1
        if known.state == ABSORBED:
            if words[NOW] - known.last > rule.memory_ns:
                known.state = FREE
        elif known.state != FREE and paused:
            hold(memory, place)
        elif known.state != FREE:
            predict(known, rule, NS * max(passed, 0))
    if count > 0:
        assign(memory, count)
    if paused:
        part_unlike(memory)
    merge_tracks(memory, count)
    split_tracks(memory, count)
    for column in range(count):
        if contacts[column].free:
            add_track(memory, column)
    for place in range(words[TOP]):
        known = tracks[place]
        if known.pair >= 0:
            update(memory, known, contacts[known.pair])
            known.column = known.pair
        waits = known.state != TENTATIVE and words[NOW] - known.last <= rule.coast_ns
        if known.column >= 0:
            again = known.last == words[NOW] and known.readings > 0  # a better answer of a reading
            known.last, known.readings = words[NOW], known.readings + (0 if again else 1)
        elif known.state != ABSORBED and not waits:
            end_track(memory, place, -1)
    for place in range(words[TOP]):
        if tracks[place].state == TENTATIVE:
            confirm(memory, place)
    finish_reading(memory)


@inner
def finish_reading(memory: TrackMemory) -> None:
    """Watch for slip, name columns as contacts came, forget places beyond the last track."""
    words, top = memory.words, 0
    for place in range(words[TOP]):
        known = memory.tracks[place]
        if known.state != FREE:
            top = place + 1
        if known.column >= 0:
            if known.state == CONFIRMED:
                watch_slip(memory, place)
            known.column = memory.contacts[known.column].origin
    words[TOP] = top


@inner
def sort_contacts(contacts: Any, count: int) -> None:
    """Sort by falling force; of equal ones by rising x, then y. All are free."""
    for column in range(count):
        contacts[column].origin, contacts[column].free = column, 1
        contacts[count], place = contacts[column], column
        one = contacts[count].mean
        while place > 0:
            other = contacts[place - 1].mean
            first, tie = one[2] > other[2], abs(one[2] - other[2]) <= TIE * abs(other[2])
            if tie:
                same = abs(one[0] - other[0]) <= TIE_PLACE
                first = one[1] < other[1] - TIE_PLACE if same else one[0] < other[0]
            if not first:
                break
            contacts[place] = contacts[place - 1]
            place -= 1
        contacts[place] = contacts[count]


@inner
def predict(known: Any, rule: Any, step: float) -> None:
    """Carry a track on by `step` s; a force does not become a pull.

    The rates are driven by white noise: Bar-Shalom, Li and Kirubarajan 2001, section 6.2.2.
    """
    mean, covariance = known.mean, known.covariance
    for i in range(3):
        mean[i] += step * mean[i + 3]
        for j in range(3):
            both = covariance[i, j + 3] + covariance[i + 3, j] + step * covariance[i + 3, j + 3]
            covariance[i, j] += step * both
    for i in range(3):
        for j in range(3):
            covariance[i, j + 3] += step * covariance[i + 3, j + 3]
            covariance[j + 3, i] = covariance[i, j + 3]
    pushes = rule.place_push, rule.place_push, rule.force_push
    push(covariance, pushes, step**3 / 3, step**2 / 2, step)
    if mean[2] < 0.0:
        mean[2] = mean[5] = 0.0


@inner
def hold(memory: TrackMemory, place: int) -> None:
    """Leave a confirmed track where it was, at rest, after a pause of readings; end any other."""
    known = memory.tracks[place]
    if known.state != CONFIRMED:
        end_track(memory, place, -1)
    mean = known.mean
    mean[3] = mean[4] = mean[5] = 0.0
    known.last = memory.words[NOW] - int(memory.rules[0].coast_ns)


@inner
def part_unlike(memory: TrackMemory) -> None:
    """End tracks whose contact after a pause has another force than theirs."""
    for place in range(memory.words[TOP]):
        known = memory.tracks[place]
        if known.state == CONFIRMED and known.pair >= 0:
            contact = memory.contacts[known.pair]
            own, its = known.mean[2], contact.mean[2]
            variance = known.covariance[2, 2] + contact.covariance[2, 2]
            if abs(own - its) > ALIKE * max(own, its) + 3.0 * np.sqrt(variance):
                contact.free, known.pair = 1, -1
                end_track(memory, place, -1)


@inner
def push(covariance: Floats, variances: Three, place: float, both: float, rate: float) -> None:
    """Add multiples of variances to those of place and force, and of their rates."""
    for i in range(3):
        covariance[i, i] += place * variances[i]
        covariance[i, i + 3] += both * variances[i]
        covariance[i + 3, i] += both * variances[i]
        covariance[i + 3, i + 3] += rate * variances[i]


@inner
def update(memory: TrackMemory, known: Any, contact: Any) -> None:
    """Take up a contact, in a track's mean and covariance.

    Where noise does that more seldom than so often a second, the rates may have changed at once.
    """
    mean, covariance, value, rule = known.mean, known.covariance, contact.mean, memory.rules[0]
    off = (value[0] - mean[0], value[1] - mean[1], value[2] - mean[2])
    white, parts = memory.work, factors(known, contact, 0.0, 0.0)
    since = NS * (memory.words[NOW] - known.last)
    if chance_beyond(square(parts, off)) < rule.false_onsets * since:
        variances = rule.speed_variance, rule.speed_variance, rule.force_rate_variance
        push(covariance, variances, since**2, since, 1.0)
        parts = factors(known, contact, 0.0, 0.0)
    first, second, third = whitened(parts, off)
    for i in range(6):
        row = whitened(parts, (covariance[i, 0], covariance[i, 1], covariance[i, 2]))
        white[0, i], white[1, i], white[2, i] = row
        mean[i] += row[0] * first + row[1] * second + row[2] * third
    for i in range(6):
        for j in range(i + 1):
            for k in range(3):
                covariance[i, j] -= white[k, i] * white[k, j]
            covariance[j, i] = covariance[i, j]
    speed = np.hypot(mean[3], mean[4])
    if speed > rule.top_speed:
        mean[3], mean[4] = mean[3] * rule.top_speed / speed, mean[4] * rule.top_speed / speed


@inner
def restart(memory: TrackMemory, place: int, column: int) -> None:
    """Begin anew at a contact, with rates of which little is known."""
    known, contact, rule = memory.tracks[place], memory.contacts[column], memory.rules[0]
    mean, covariance, value, noise = known.mean, known.covariance, contact.mean, contact.covariance
    for i in range(3):
        mean[i] = value[i]
        for j in range(3):
            covariance[i, j] = noise[i, j]
            covariance[i, j + 3] = covariance[i + 3, j] = covariance[i + 3, j + 3] = 0.0
        covariance[i + 3, i + 3] = rule.speed_variance if i < 2 else rule.force_rate_variance
    known.column, known.pair, contact.free = column, -1, 0


@inner
def add_track(memory: TrackMemory, column: int) -> int:
    """Begin a track, if need be in place of the one not seen for longest; where it is."""
    tracks, words, place, last = memory.tracks, memory.words, -1, 0
    for each in range(len(tracks)):
        known = tracks[each]
        if known.state == FREE:
            place = each
            break
        if known.column < 0 and known.pair < 0 and (place < 0 or known.last < last):
            place, last = each, known.last
    end_track(memory, place, -1)
    words[TOP] = max(words[TOP], place + 1)
    memory.ids[0] += 1
    known, mean = tracks[place], tracks[place].mean
    known.number, known.made, known.slipped = memory.ids[0], words[NOW], words[NOW]
    known.state, known.parent, known.readings, known.slips = TENTATIVE, -1, 0, 0
    mean[3] = mean[4] = mean[5] = 0.0
    restart(memory, place, column)
    return place


@inner
def end_track(memory: TrackMemory, place: int, heir: int) -> None:
    """End a track, if there is one. What it absorbed goes to an heir; -1: it is lost."""
    if memory.tracks[place].state == CONFIRMED:
        if heir < 0:
            report(memory, LOST, place, -1)
        for other in range(memory.words[TOP]):
            known = memory.tracks[other]
            if known.parent == place and known.state == ABSORBED:
                known.parent, known.state = heir, ABSORBED if heir >= 0 else FREE
            elif known.parent == place:
                known.parent = GONE
    memory.tracks[place].state = FREE


@inner
def report(memory: TrackMemory, kind: int, place: int, other: int) -> None:
    """Write an event of a track, and of another number."""
    words, known = memory.words, memory.tracks[place]
    event = memory.events[words[EVENTS] % len(memory.events)]
    ids, where, mean = event.ids, event.place, known.mean
    event.kind, event.time, ids[0], ids[1] = kind, words[NOW], known.number, other
    where[0], where[1] = mean[0], mean[1]
    words[EVENTS] += 1


@inner
def assign(memory: TrackMemory, count: int) -> None:
    """Write which contact is to go on with which track: the sum of the gains is the highest.

    A pair costs the squared Mahalanobis distance of the place and, up to a limit, that of the
    force, and the logarithm of the place's variance: of two as near, the surer one goes on.
    """
    tracks, contacts, gains, many = memory.tracks, memory.contacts, memory.gains, 0
    listed, match = memory.lists[0], memory.lists[1]
    for place in range(memory.words[TOP]):
        if tracks[place].state == TENTATIVE or tracks[place].state == CONFIRMED:
            listed[many] = place
            many += 1
    columns = max(many, count)
    for row in range(many):
        for column in range(columns):
            pair = tracks[listed[row]], contacts[column]
            gains[row, column] = gain_of(*pair, memory.rules[0]) if column < count else 0.0
    pair_best(gains, many, columns, memory.work, match, memory.lists[2], memory.lists[3])
    for column in range(count):
        row = match[column + 1] - 1
        if row >= 0 and gains[row, column] > 0.0:
            tracks[listed[row]].pair, contacts[column].free = column, 0


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
def gain_of(known: Any, contact: Any, rule: Any) -> float:
    """What a pair of a track and a contact is worth; 0 beyond the gate, or of what is no number."""
    mean, covariance, value, noise = known.mean, known.covariance, contact.mean, contact.covariance
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
    gain = rule.gate + FORCE_COST + HANDICAP - distance - np.log(area / floor**2)
    gain -= min(force * force / (covariance[2, 2] + noise[2, 2]), FORCE_COST)
    gain -= 0.0 if known.state == CONFIRMED else HANDICAP
    return float(gain) if gain > 0.0 else 0.0


@inner
def misfit(one: Any, other: Any, floor: float) -> tuple[float, float]:
    """Squared distance of two loads, and twice the negative logarithm of its density.

    `floor` m is added to the standard deviation of the place, and a share of the force to its own.
    """
    own, its = one.mean, other.mean
    parts = factors(one, other, floor**2, (FORCE_FLOOR * max(own[2], its[2])) ** 2)
    distance = square(parts, (own[0] - its[0], own[1] - its[1], own[2] - its[2]))
    return distance, distance + 2.0 * np.log(parts[0] * parts[1] * parts[2])


@inner
def add_loads(one: Any, other: Any, both: Any) -> None:
    """Write the sum of two loads, at their centre; its covariance to first order."""
    own, its, value, spread = one.mean, other.mean, both.mean, both.covariance
    # a force below its own uncertainty says nothing of where the centre is
    force = max(own[2], np.sqrt(one.covariance[2, 2]))
    total = force + max(its[2], np.sqrt(other.covariance[2, 2]))
    share = force / total
    x, y = (own[0] - its[0]) / total, (own[1] - its[1]) / total
    for i in range(3):
        value[i] = share * own[i] + (1.0 - share) * its[i] if i < 2 else own[i] + its[i]
        for j in range(3):
            spread[i, j] = 0.0
    for part in range(2):
        noise = one.covariance if part == 0 else other.covariance
        s = share if part == 0 else 1.0 - share
        u, v = ((1.0 - s) * x, (1.0 - s) * y) if part == 0 else ((s - 1.0) * x, (s - 1.0) * y)
        xf, yf, ff = noise[0, 2], noise[1, 2], noise[2, 2]
        spread[0, 0] += s * s * noise[0, 0] + 2 * s * u * xf + u * u * ff
        spread[1, 1] += s * s * noise[1, 1] + 2 * s * v * yf + v * v * ff
        spread[0, 1] += s * s * noise[0, 1] + s * v * xf + s * u * yf + u * v * ff
        spread[0, 2] += s * xf + u * ff
        spread[1, 2] += s * yf + v * ff
        spread[2, 2] += ff


@inner
def sum_score(memory: TrackMemory, whole: Any, one: Any, other: Any) -> tuple[float, bool]:
    """How badly a load fits the sum of two, and whether it is that, rather than one of them."""
    both, floor = memory.contacts[len(memory.contacts) - 1], memory.rules[0].floor
    add_loads(one, other, both)
    distance, score = misfit(both, whole, floor)
    alone = min(misfit(one, whole, floor)[1], misfit(other, whole, floor)[1])
    return score, distance < LIMIT and score < alone


@inner
def distance_of(one: Any, other: Any) -> float:
    """Of two loads, m."""
    own, its = one.mean, other.mean
    return float(np.hypot(own[0] - its[0], own[1] - its[1]))


@inner
def is_open(known: Any) -> bool:
    """Whether a track is confirmed, and did not begin anew in this step."""
    return bool(known.state == CONFIRMED and known.column < 0)


@inner
def merge_tracks(memory: TrackMemory, count: int) -> None:
    """Merge tracks that are not seen, but whose force is in another's contact."""
    tracks, contacts, near = memory.tracks, memory.contacts, memory.rules[0].near
    for goes in range(memory.words[TOP]):
        ends, best, stays, contact = tracks[goes], np.inf, -1, -1
        if not is_open(ends) or ends.pair >= 0:
            continue
        for place in range(memory.words[TOP]):
            known = tracks[place]
            if place == goes or not is_open(known) or distance_of(known, ends) > near:
                continue
            for column in range(count):
                if column == known.pair or (known.pair < 0 and contacts[column].free):
                    score, fits = sum_score(memory, contacts[column], known, ends)
                    if fits and score < best:
                        best, stays, contact = score, place, column
        if stays >= 0:
            absorb(memory, goes, stays, contact)


@inner
def absorb(memory: TrackMemory, one: int, other: int, column: int) -> None:
    """Merge two tracks, to begin anew where both are seen.

    The stronger has the number; where their forces do not tell, by one standard deviation of the
    difference, the older.
    """
    mine, its = memory.tracks[one], memory.tracks[other]
    more = mine.mean[2] - its.mean[2]
    is_one = more > 0.0
    if more * more < mine.covariance[2, 2] + its.covariance[2, 2] and mine.made != its.made:
        is_one = mine.made < its.made
    place, ends = (one, other) if is_one else (other, one)
    stays, goes = memory.tracks[place], memory.tracks[ends]
    mean, apart, covariance, sums = stays.mean, goes.mean, stays.covariance, goes.covariance
    own, others = max(mean[2], LEAST), max(apart[2], LEAST)
    goes.whole = mean[2] + apart[2]
    for i in range(6):
        apart[i] -= mean[i]
        for j in range(6):
            sums[i, j] += covariance[i, j]
    end_track(memory, ends, place)
    goes.state, goes.parent, goes.last, goes.pair = ABSORBED, place, memory.words[NOW], -1
    for i in range(3, 5):  # the centre's
        mean[i] += others / (own + others) * apart[i]
    mean[5] = 0.0
    restart(memory, place, column)
    report(memory, MERGED, place, goes.number)


@inner
def split_tracks(memory: TrackMemory, count: int) -> None:
    """Split tracks whose force is in a contact without a track.

    Of a track that absorbed another shortly before, two contacts nearby are taken for both.
    """
    tracks, contacts, near = memory.tracks, memory.contacts, memory.rules[0].near
    for column in range(count):
        best, whole, other = np.inf, -1, -1
        for place in range(memory.words[TOP]):
            known = tracks[place]
            far = distance_of(known, contacts[column]) > near
            if not contacts[column].free or not is_open(known) or far:
                continue
            for half in range(count):
                can = known.pair < 0 and contacts[half].free and half != column
                if (can or half == known.pair) and distance_of(known, contacts[half]) <= near:
                    parts = contacts[half], contacts[column]
                    score, fits = sum_score(memory, known, *parts)
                    fits = fits and distance_of(*parts) <= near
                    if (fits or newest_absorbed(memory, place) >= 0) and score < best:
                        best, whole, other = score, place, half
        if whole >= 0:
            divide(memory, whole, other, column)


@inner
def newest_absorbed(memory: TrackMemory, place: int) -> int:
    """Place of what a track absorbed last; -1: nothing."""
    newest, tracks = -1, memory.tracks
    for each in range(memory.words[TOP]):
        its = tracks[each].state == ABSORBED and tracks[each].parent == place
        if its and (newest < 0 or tracks[each].last > tracks[newest].last):
            newest = each
    return newest


@inner
def divide(memory: TrackMemory, whole: int, half: int, other: int) -> None:
    """Split a track: the contact that it had goes on, else the nearer; if as near, the stronger."""
    known, contacts, swap = memory.tracks[whole], memory.contacts, False
    if known.pair != half:
        away = distance_of(known, contacts[half]) - distance_of(known, contacts[other])
        swap = away > TIE_DISTANCE or (abs(away) <= TIE_DISTANCE and other < half)
    near, far = (other, half) if swap else (half, other)
    restart(memory, whole, near)
    memory.tracks[add_track(memory, far)].parent = whole


@inner
def confirm(memory: TrackMemory, place: int) -> None:
    """Confirm a strong contact; a weak one, and a part of another, after some readings."""
    known, rule, parent = memory.tracks[place], memory.rules[0], memory.tracks[place].parent
    contact = memory.contacts[known.column]
    strong = contact.mean[2] >= rule.strong * np.sqrt(contact.covariance[2, 2])
    if known.readings < rule.weak_readings and (parent != -1 or not strong):
        return
    known.state, known.parent = CONFIRMED, -1
    if parent < 0 or memory.tracks[parent].state != CONFIRMED:
        report(memory, MADE, place, -1)
        return
    newest, stays = newest_absorbed(memory, parent), memory.tracks[parent]
    if newest >= 0:
        past = memory.tracks[newest]
        past.state = FREE
        exchange(past, known)
        if is_exchanged(memory, past, stays, known):
            exchange(stays, known)
    report(memory, SPLIT, parent, known.number)


@inner
def exchange(one: Any, other: Any) -> None:
    """Exchange two identities."""
    one.number, other.number = other.number, one.number
    one.made, other.made = other.made, one.made
    one.slipped, other.slipped = other.slipped, one.slipped
    one.slips, other.slips = other.slips, one.slips


@inner
def is_exchanged(memory: TrackMemory, past: Any, stays: Any, child: Any) -> bool:
    """Whether after a split the new track is what had stayed, and the other one came back.

    The distance of both is carried on from when they merged. Solid bodies do not pass through each
    other: those whose ways would have met turned back, and kept their sides.
    """
    mean, its, rule = stays.mean, child.mean, memory.rules[0]
    apart, spread = past.mean, past.covariance
    span = NS * (memory.words[NOW] - past.last)
    across = apart[0] * apart[4] - apart[1] * apart[3]
    carried = span if abs(across) > NARROW * np.hypot(apart[3], apart[4]) else 0.0
    x, y = apart[0] + carried * apart[3], apart[1] + carried * apart[4]
    variance = 0.5 * (spread[0, 0] + spread[1, 1] + span**2 * (spread[3, 3] + spread[4, 4]))
    variance += 2 * rule.place_push * span**3 / 3 + rule.floor**2
    favour = 2.0 * ((its[0] - mean[0]) * x + (its[1] - mean[1]) * y) / variance
    unsure = (FORCE_FLOOR * past.whole) ** 2 + rule.force_push * span**3 / 3
    unsure += child.covariance[2, 2] + stays.covariance[2, 2]
    return bool(favour + (its[2] - mean[2]) * apart[2] / unsure < 0.0)


@inner
def watch_slip(memory: TrackMemory, place: int) -> None:
    """Say whether a place moves: by its speed, beyond doubt, or as it has hardly slowed."""
    known, rule = memory.tracks[place], memory.rules[0]
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

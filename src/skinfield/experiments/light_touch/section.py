"""Light touch: the detector beside the paper's method and beside what no test can beat."""

from collections.abc import Sequence

from skinfield.experiments.light_touch.live import Live, idle_alarms, watched
from skinfield.experiments.light_touch.pictures import (
    picture_of_forces,
    picture_of_rocs,
    picture_of_time,
)
from skinfield.experiments.light_touch.rates import Found
from skinfield.experiments.light_touch.trials import (
    BOUND,
    KINDS,
    LOOKED,
    MATCH,
    OURS,
    PAPERS,
    TAXEL,
    Touch,
)
from skinfield.experiments.paper.presses import PLACES
from skinfield.experiments.scoring.statistics import wilson
from skinfield.experiments.section import Section, Table
from skinfield.experiments.settings import Settings
from skinfield.experiments.words import listed, share_in_words

CLAIM = "With 0.2 N over a taxel the contact cannot be isolated from noise, whatever the grid."
LIGHT = (0.2, 0.1)  # N over a taxel
WATCHED = ((0.1, PLACES[0]), (0.2, PLACES[0]), (0.4, PLACES[1]), (0.4, PLACES[2]))  # live


def light_touch(settings: Settings) -> Section:
    """Shares of light touches found, the rate of false alarms, and the time that it takes."""
    found = Found(settings)
    shown = WATCHED[: 2 if settings.size.name == "smoke" else None]
    runs = [
        watched(Touch("stress", place, force), settings, seed)
        for seed, (force, place) in enumerate(shown)
    ]
    return Section(
        name="light-touch",
        title="Light touch",
        claim=CLAIM,
        sentences=tuple(_sentences(found, runs)),
        pictures=(picture_of_rocs(found), picture_of_forces(found), picture_of_time(runs, found)),
        tables=(_light(found), _alarms(found), _everything(found)),
    )


def _sentences(found: Found, runs: Sequence[Live]) -> list[str]:
    settings = found.settings

    def share(method: str, force: float, place: str = PLACES[0], reads: str = "stress") -> str:
        one = found.share(method, Touch(reads, place, force))
        return share_in_words(one.value, (one.low, one.high))

    def percent(method: str, force: float, place: str = PLACES[0], reads: str = "stress") -> str:
        return f"{100 * found.share(method, Touch(reads, place, force)).value:.0f} %"

    seconds, two, first = LOOKED / settings.rate, PLACES[1], runs[0]
    reached = [f"{share(OURS, force)} of {force:g} N" for force in LIGHT]
    return [
        f"Over a taxel, in {LOOKED} readings ({seconds:g} s) of {settings.stress_noise / 1e3:g} "
        f"kPa noise each and at {settings.false_alarms:g} false alarms per decision, the detector "
        f"finds {listed(reached)}. On means of the same readings the paper's method finds "
        f"{percent(PAPERS, 0.1)} of 0.1 N, and the highest taxel {percent(TAXEL, 0.1)}: over a "
        "taxel a light touch is a matter of that taxel alone.",
        f"Between two taxels the marginal likelihood finds {percent(OURS, 0.2, two)} of 0.2 N, the "
        f"largest match {percent(MATCH, 0.2, two)}, the highest taxel {percent(TAXEL, 0.2, two)}, "
        f"the paper's method {percent(PAPERS, 0.2, two)}; a filter that is told place and shape "
        f"{percent(BOUND, 0.2, two)}. The difference is the price of looking everywhere.",
        f"Where taxels read ΔC/C₀ with a noise of {settings.change_noise:g}, the detector finds "
        f"{share(OURS, 0.1, reads='capacitance')} of 0.1 N over a taxel; told place and shape it "
        f"would be {percent(BOUND, 0.1, reads='capacitance')}.",
        f"A stream that looks back over several lengths with every reading sees "
        f"{100 * first.once[LOOKED - 1]:.0f} % of 0.1 N over a taxel within {seconds:g} s.",
    ]


def _light(found: Found) -> Table:
    names = list(dict.fromkeys(each.method for each in found.shares))
    rows = []
    for quantity in ("stress", "capacitance"):
        for force in [force for force in found.forces if force in (0.1, 0.2, 0.4)]:
            for place in KINDS:
                touch = Touch(quantity, place, force)
                shares = {s.method: s for s in found.shares if s.touch == touch}
                cells = [
                    None if name not in shares else f"{100 * shares[name].value:.1f}"
                    for name in names
                ]
                rows.append((quantity, force, place, *cells))
    caption = (
        f"Share found (%) over {LOOKED} readings at {found.settings.false_alarms:g} false alarms "
        "per decision."
    )
    columns = ("reads", "force (N)", "place", *(f"{name} (%)" for name in names))
    return Table("light", caption, columns, tuple(rows))


def _alarms(found: Found) -> Table:
    rows = []
    for quantity, method, stated, alarms, count in found.false_alarms():
        low, high = wilson(alarms, count)
        rows.append((quantity, method, stated, alarms, count, alarms / count, low, high))
    alarms, count = idle_alarms(found.settings, "stress")
    low, high = wilson(alarms, count)
    stated = found.settings.false_alarms
    rows.append(("stress", "stream", stated, alarms, count, alarms / count, low, high))
    caption = (
        "False alarms on idle readings that no threshold was set on, with 95 % intervals. Each "
        "threshold is set so that its rate is, with some certainty, below the stated one."
    )
    columns = ("reads", "method", "stated rate", "alarms", "of", "rate", "from", "to")
    return Table("false-alarms", caption, columns, tuple(rows))


def _everything(found: Found) -> Table:
    rows = tuple(
        (s.method, s.touch.quantity, s.touch.place, s.touch.force, s.value, s.low, s.high)
        for s in found.shares
    )
    columns = ("method", "reads", "place", "force (N)", "share", "from", "to")
    return Table("all", "Every share.", columns, rows, shown=False)

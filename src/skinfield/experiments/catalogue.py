"""All experiments, in the order of the page: one more is one file, and one line here."""

from skinfield.experiments.accuracy.section import accuracy, accuracy_parts
from skinfield.experiments.coverage.section import coverage, coverage_parts_of
from skinfield.experiments.light_touch.section import light_touch
from skinfield.experiments.paper.detection import detection
from skinfield.experiments.paper.half_space_error import half_space_error
from skinfield.experiments.paper.imposed import imposed
from skinfield.experiments.paper.judged import judged
from skinfield.experiments.paper.resolutions import resolutions
from skinfield.experiments.paper.timing import timing
from skinfield.experiments.recorded.sections import RECORDED, recorded
from skinfield.experiments.section import Experiment
from skinfield.experiments.tracks.section import tracks, tracks_parts_of
from skinfield.experiments.trust.section import trust, trust_parts_of

EXPERIMENTS = (
    Experiment("imposed", ("fig3", "fig4", "fig5"), imposed),
    Experiment("detection", ("fig6", "fig7"), detection),
    Experiment("light-touch", ("touch",), light_touch),
    Experiment("resolutions", ("fig8",), resolutions),
    Experiment("timing", ("fig9",), timing, alone=True),
    Experiment("accuracy", ("table",), accuracy, parts=accuracy_parts),
    Experiment("trust", ("contacts",), trust, parts=trust_parts_of),
    Experiment("coverage", ("intervals",), coverage, parts=coverage_parts_of),
    Experiment("tracks", ("time",), tracks, parts=tracks_parts_of),
    Experiment("half-space", ("model",), half_space_error),
    Experiment("agreement", ("fem",), judged),
    *(Experiment(f"real-{name}", ("real-data",), recorded, (name,)) for name in RECORDED),
)

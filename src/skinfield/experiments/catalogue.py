"""All experiments, in the order of the page: one more is one file, and one line here."""

from skinfield.experiments.accuracy_section import accuracy, accuracy_parts
from skinfield.experiments.detection import detection
from skinfield.experiments.half_space_error import half_space_error
from skinfield.experiments.imposed import imposed
from skinfield.experiments.judged import judged
from skinfield.experiments.recorded import RECORDED, recorded
from skinfield.experiments.resolutions import resolutions
from skinfield.experiments.section import Experiment
from skinfield.experiments.timing import timing

EXPERIMENTS = (
    Experiment("imposed", ("fig3", "fig4", "fig5"), imposed),
    Experiment("detection", ("fig6", "fig7"), detection),
    Experiment("resolutions", ("fig8",), resolutions),
    Experiment("timing", ("fig9",), timing, alone=True),
    Experiment("accuracy", ("table",), accuracy, parts=accuracy_parts),
    Experiment("half-space", ("model",), half_space_error),
    Experiment("agreement", ("fem",), judged),
    *(Experiment(f"real-{name}", ("real-data",), recorded, (name,)) for name in RECORDED),
)

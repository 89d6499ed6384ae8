"""Many runs at once, which can be stopped at any time and gone on with later. Knows no physics.

A task is a function of the module level with its arguments. It gets a folder of its own, writes
files there, and may return a summary that JSON can hold::

    def measure(folder: Path, load: float, seed: int) -> dict[str, float]:
        np.savez(folder / "result.npz", ...)
        return {"peak_N": load}

    tasks = [Task(f"load-{load:g}N", measure, (load, 0)) for load in (0.2, 0.5, 1.8)]
    for event in run(tasks, "out", workers=2):
        print(f"{event.done}/{event.total} {event.outcome.name} {event.failures} failed")

Afterwards ``out/load-0.2N`` holds ``result.npz`` and ``task.json``: the fingerprint of the task,
the seconds that it took and its summary. The folder appears whole or not at all, as it is written
under another name. A task whose folder has the same fingerprint, a hash of the function's name,
the arguments and the task's `version`, is not run again. A task that fails leaves its traceback
in ``out/load-0.2N.failed.txt`` and stops no other.

`run` is a generator of `Event`; whoever stops asking stops the campaign, and Ctrl-C does. With
more than one worker tasks run in processes of their own, with one thread each for BLAS and
Numba; a script that calls `run` then needs ``if __name__ == "__main__":``. `stored` reads what
there is without running anything. One campaign at a time may write to a folder.
"""

from skinfield.campaign.ordered import in_order as in_order
from skinfield.campaign.outcome import Outcome as Outcome
from skinfield.campaign.outcome import stored as stored
from skinfield.campaign.runner import Event as Event
from skinfield.campaign.runner import run as run
from skinfield.campaign.task import Task as Task
from skinfield.campaign.task import fingerprint as fingerprint

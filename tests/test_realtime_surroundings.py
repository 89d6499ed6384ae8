"""What disturbs a real-time process on this machine; checked on made-up files of the system."""

import os
from pathlib import Path

import pytest

from skinfield.realtime import requests, surroundings, system
from skinfield.realtime import rivals as rivals_module
from skinfield.realtime.rivals import rivals
from skinfield.realtime.system import cpus_of


def machine(monkeypatch: pytest.MonkeyPatch, files: dict[str, str]) -> None:
    read = lambda path: files.get(str(path), "")
    monkeypatch.setattr(surroundings, "read_text", read)
    monkeypatch.setattr(requests, "read_text", read)
    monkeypatch.setattr(surroundings, "rivals", lambda: ())
    monkeypatch.setattr(system, "LINUX", True)


def test_what_disturbs_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    cpu = "/sys/devices/system/cpu"
    machine(
        monkeypatch,
        {
            "/proc/sys/kernel/sched_rt_runtime_us": "950000\n",
            "/proc/sys/kernel/sched_rt_period_us": "1000000\n",
            f"{cpu}/cpu3/cpufreq/scaling_governor": "powersave\n",
            f"{cpu}/cpu3/topology/thread_siblings_list": "1,3\n",
            "/proc/swaps": "Filename Type Size Used Priority\n/dev/sda2 partition 999 123 -2\n",
            "/proc/cpuinfo": "flags : fpu vme hypervisor\n",
        },
    )
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    text = "\n".join(surroundings.disturbances(3))
    for words in (
        "has one CPU",
        "950 of 1000 ms",
        "governor of CPU 3 is powersave",
        "shares its core with CPU 1",
        "swap is in use",
        "virtual machine",
    ):
        assert words in text


def test_a_quiet_machine_has_nothing_to_say(monkeypatch: pytest.MonkeyPatch) -> None:
    machine(
        monkeypatch,
        {
            "/proc/sys/kernel/sched_rt_runtime_us": "-1\n",
            "/proc/sys/kernel/sched_rt_period_us": "1000000\n",
            "/sys/devices/system/cpu/cpu3/cpufreq/scaling_governor": "performance\n",
            "/sys/devices/system/cpu/cpu3/topology/thread_siblings_list": "3\n",
            "/proc/swaps": "Filename Type Size Used Priority\n/dev/sda2 partition 999 0 -2\n",
        },
    )
    monkeypatch.setattr(os, "cpu_count", lambda: 4)
    monkeypatch.setattr(surroundings.threading, "active_count", lambda: 1)
    assert surroundings.disturbances(3) == ()


@pytest.mark.parametrize(
    ("allowed", "isolated", "wanted"),
    [
        ({0, 1}, "2-3", {2, 3}),  # left out by the system alone
        ({0, 3}, "2-3", {3}),  # somebody chose these
        ({0, 1, 2, 3}, "", set()),
    ],
)
def test_isolated_processors_are_taken_but_a_narrower_choice_is_kept(
    monkeypatch: pytest.MonkeyPatch, allowed: set[int], isolated: str, wanted: set[int]
) -> None:
    machine(monkeypatch, {"/sys/devices/system/cpu/online": "0-3\n"})
    assert requests._isolated_choices(allowed, cpus_of(isolated)) == wanted


def test_lists_of_processors() -> None:
    assert cpus_of("0-2,5\n") == {0, 1, 2, 5}
    assert cpus_of("\n") == cpus_of("(null)") == cpus_of("1-x") == set()


def thread(folder: Path, number: int, stat: str, cpus: str) -> None:
    place = folder / str(number) / "task" / str(number)
    place.mkdir(parents=True)
    (place / "stat").write_text(stat)
    (place / "status").write_text(f"Name: x\nCpus_allowed_list:\t{cpus}\n")


def test_rivals_are_pinned_real_time_programs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = "{} ({}) S 1 1 1 0 -1 {} " + "0 " * 30 + "{} 1 0"
    thread(tmp_path, 11, line.format(11, "an engine) (2", 0x400, 80), "3")
    thread(tmp_path, 12, line.format(12, "free", 0x400, 80), "0-3")
    thread(tmp_path, 13, line.format(13, "usual", 0x400, 0), "3")
    thread(tmp_path, 14, line.format(14, "migration/3", 0x200000, 99), "3")
    thread(tmp_path, 15, "damaged", "3")
    monkeypatch.setattr(rivals_module, "PROCESSES", tmp_path)
    (found,) = rivals()
    assert (found.process, found.priority, found.cpu) == (11, 80, 3)

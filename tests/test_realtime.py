"""Real time: what the system grants, on this machine, on fakes and on made-up files."""

import errno
import gc
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from skinfield.errors import InputError
from skinfield.loop.realtime import RealTime, RealTimeStatus, setup, system
from skinfield.loop.realtime.system import competitors, cpus_of

LINUX = sys.platform == "linux"
ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
FIFO = 1  # number of the policy, of linux/sched.h

PRELUDE = """
import gc, json, os, resource, threading
from skinfield.loop.realtime import RealTime, setup, system
"""
REPORT = """
granted = RealTime(priority={priority}).apply()
stat = open("/proc/self/stat").read().rpartition(")")[2].split()
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
print(json.dumps(dict(
    granted=granted.as_dict(), rt_priority=int(stat[37]), policy=int(stat[38]),
    cpus=status["Cpus_allowed_list"].strip(), locked_kb=int(status["VmLck"].split()[0]),
    gc=gc.isenabled(), frozen=gc.get_freeze_count(),
)))
"""
NOBODY = """
for name, limit in {limits}.items():
    try:
        resource.setrlimit(getattr(resource, name), (limit, limit))
    except ValueError as error:  # root of some containers may not raise them
        raise SystemExit(print(json.dumps(dict(impossible=str(error)))))
os.setgroups([]); os.setgid(65534); os.setuid(65534)
"""


def child(*parts: str) -> dict:
    if not LINUX:
        pytest.skip("asks Linux")
    ended = subprocess.run(
        [sys.executable, "-c", "".join((PRELUDE, *parts))],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    found = json.loads(ended.stdout)
    if "impossible" in found:
        pytest.skip(found["impossible"])
    return found


def test_what_is_reported_is_what_the_system_says() -> None:
    found = child(REPORT.format(priority=70))
    granted = RealTimeStatus.from_dict(found["granted"])
    assert granted.real_time == (found["policy"] == FIFO)
    assert granted.priority == found["rt_priority"]
    assert granted.priority in (0, 70) or any("priority 70" in each for each in granted.refused)
    assert granted.real_time or any("SCHED_FIFO not granted" in each for each in granted.refused)
    assert str(granted.cpu) == found["cpus"]
    assert (granted.memory == "not locked") == (found["locked_kb"] == 0)
    assert granted.gc_frozen
    assert not found["gc"]
    assert found["frozen"] > 1000
    assert RealTimeStatus.from_dict(json.loads(json.dumps(granted.as_dict()))) == granted


def test_without_permissions_each_refusal_is_said_with_its_remedy() -> None:
    if not (LINUX and ROOT):
        pytest.skip("only root can become somebody without permissions")
    limits = {"RLIMIT_RTPRIO": 0, "RLIMIT_MEMLOCK": 8 << 20}
    found = child(NOBODY.format(limits=limits), REPORT.format(priority=80))
    assert (found["policy"], found["rt_priority"], found["locked_kb"]) == (0, 0, 0)
    granted = RealTimeStatus.from_dict(found["granted"])
    assert not granted.real_time
    assert granted.scheduler == "SCHED_OTHER"
    refused = {each.partition(":")[0]: each for each in granted.refused}
    scheduling = refused["SCHED_FIFO not granted"]
    assert "Operation not permitted" in scheduling
    assert "`@realtime - rtprio 90`" in scheduling
    assert "usermod -aG realtime" in scheduling
    assert "`@realtime - memlock unlimited`" in refused["memory not locked"]
    assert granted.gc_frozen  # which nobody has to permit
    assert str(granted.cpu) == found["cpus"]
    assert granted.sentences()[0].startswith("ordinary scheduling (SCHED_OTHER)")


def test_a_process_that_was_started_in_real_time_says_so() -> None:
    found = child("""
try:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(7))
except PermissionError as error:
    raise SystemExit(print(json.dumps(dict(impossible=str(error)))))
granted = RealTime(priority=0, lock_memory=False, keep_awake=False).apply()
print(json.dumps(granted.as_dict()))
""")
    assert (found["scheduler"], found["priority"]) == ("SCHED_FIFO", 7)


def test_a_processor_that_is_not_there_is_refused_and_said() -> None:
    found = child("""
before = sorted(os.sched_getaffinity(0))
granted = RealTime(priority=0, cpu=4095, lock_memory=False, keep_awake=False).apply()
print(json.dumps(dict(granted=granted.as_dict(), same=before == sorted(os.sched_getaffinity(0)))))
""")
    assert found["same"]
    assert found["granted"]["cpu"] is None
    assert "CPU 4095 not granted: Invalid argument" in found["granted"]["refused"][0]
    assert found["granted"]["memory"] == "not locked"


def test_another_system_grants_nothing_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "LINUX", False)
    monkeypatch.setattr(system, "LIBRARY", None)
    monkeypatch.setattr(setup.sys, "platform", "darwin")
    for name in ("sched_setscheduler", "sched_getscheduler", "sched_setaffinity"):
        monkeypatch.delattr(os, name, raising=False)  # as it is there
    granted = RealTime(freeze_gc=False).apply()
    assert not granted.real_time
    assert (granted.cpu, granted.memory) == (None, "not locked")
    assert "this is darwin" in granted.refused[0]
    assert len(granted.refused) == 1
    assert gc.isenabled()


class Libc:
    """What would be asked of the system."""

    def __init__(self, limits: dict[str, int]) -> None:
        self.limits, self.asked = limits, []

    def call(self, name: str, *arguments: int) -> int:
        self.asked.append((name, arguments))
        return 1

    def schedule(self, _: int, policy: int, param: os.sched_param) -> None:
        self.asked.append(("sched_setscheduler", (policy, param.sched_priority)))
        if param.sched_priority > self.limits["RLIMIT_RTPRIO"]:
            raise PermissionError(1, "Operation not permitted")


@pytest.fixture
def libc(monkeypatch: pytest.MonkeyPatch) -> Libc:
    if not LINUX:
        pytest.skip("asks Linux")
    fake = Libc({"RLIMIT_RTPRIO": 30, "RLIMIT_MEMLOCK": 64 << 30})
    monkeypatch.setattr(system, "call", fake.call)
    monkeypatch.setattr(os, "sched_setscheduler", fake.schedule)
    monkeypatch.setattr(setup, "_raise_limit", lambda name: (fake.limits[name],) * 2)
    monkeypatch.setattr(setup, "capabilities", lambda: 0)
    return fake


def found_by(request, **settings) -> setup.Outcome:
    found = setup.Outcome()
    request(RealTime(**settings), found)
    return found


def test_the_priority_that_a_limit_permits_is_taken(libc: Libc) -> None:
    found = found_by(setup._schedule, priority=80)
    assert found.granted == {"scheduler": "SCHED_FIFO", "priority": 30}
    assert "priority 80 not granted, 30 is" in found.refused[0]
    tried = [arguments for name, arguments in libc.asked if name == "sched_setscheduler"]
    assert tried == [(os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, each) for each in (80, 30)]
    assert found_by(setup._schedule, priority=20).refused == []


def test_an_older_linux_locks_untouched_pages_too(
    libc: Libc, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def call(name: str, *arguments: int) -> int:
        asked.append((name, arguments))
        if name == "mlockall" and arguments[0] & system.MCL_ONFAULT:
            raise OSError(errno.EINVAL, "Invalid argument")
        return 1

    monkeypatch.setattr(system, "call", call)
    assert found_by(setup._lock).granted["memory"] == "locked so far"
    assert asked[-1] == ("mlockall", (system.MCL_CURRENT,))


@pytest.mark.parametrize(
    ("limit", "memory", "flags"), [(64 << 30, "locked so far", 1 | 4), (-1, "locked", 1 | 2 | 4)]
)
def test_memory_is_locked_as_far_as_its_limit_lets(
    libc: Libc, limit: int, memory: str, flags: int
) -> None:
    libc.limits["RLIMIT_MEMLOCK"] = limit
    found = found_by(setup._lock)
    assert found.granted == {"memory": memory}
    assert ("mlockall", (flags,)) in libc.asked
    assert [each.partition(":")[0] for each in found.refused] == (
        [] if limit < 0 else ["later memory not locked"]
    )


def test_a_competitor_is_found_and_its_processor_avoided() -> None:
    found = child(
        """
import subprocess, sys
from skinfield.loop.realtime.system import competitors
first = RealTime(lock_memory=False, keep_awake=False).apply()
told = subprocess.run([sys.executable, "-c", '''
import json, os, sys
from skinfield.loop.realtime import RealTime
from skinfield.loop.realtime.system import competitors
os.sched_setaffinity(0, json.loads(sys.argv[1]))
mine = [each.cpu for each in competitors() if each.process == os.getppid()]
taken = [each.cpu for each in competitors()]
second = RealTime(lock_memory=False, keep_awake=False).apply()
print(json.dumps([mine, taken, second.as_dict()]))
''', json.dumps(cpus)], stdout=subprocess.PIPE, text=True, check=True)
print(json.dumps([first.as_dict(), *json.loads(told.stdout)]))
""".replace("import subprocess", "cpus = sorted(os.sched_getaffinity(0))\nimport subprocess", 1)
    )
    first, mine, taken, second = found
    if not first["priority"]:
        pytest.skip("real time is not permitted")
    assert mine == [first["cpu"]]
    said = any(f"CPU {second['cpu']} is also that of" in each for each in second["disturbances"])
    assert second["cpu"] not in taken or said


@pytest.mark.parametrize("wrong", [{"priority": 100}, {"priority": -1}, {"cpu": -1}])
def test_settings_that_no_system_has_are_refused(wrong: dict) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        RealTime(**wrong)


def machine(monkeypatch: pytest.MonkeyPatch, files: dict[str, str]) -> None:
    read = lambda path: files.get(str(path), "")
    monkeypatch.setattr(system, "read_text", read)
    monkeypatch.setattr(setup, "read_text", read)
    monkeypatch.setattr(system, "competitors", lambda: ())
    monkeypatch.setattr(system, "LINUX", True)


@pytest.mark.parametrize("quiet", [False, True])
def test_what_disturbs_is_said(monkeypatch: pytest.MonkeyPatch, quiet: bool) -> None:
    cpu = "/sys/devices/system/cpu/cpu3"
    swap = "Filename Type Size Used Priority\n/dev/sda2 partition 999 {} -2\n"
    machine(
        monkeypatch,
        {
            "/proc/sys/kernel/sched_rt_runtime_us": "-1\n" if quiet else "950000\n",
            "/proc/sys/kernel/sched_rt_period_us": "1000000\n",
            f"{cpu}/cpufreq/scaling_governor": "performance\n" if quiet else "powersave\n",
            f"{cpu}/topology/thread_siblings_list": "3\n" if quiet else "1,3\n",
            "/proc/swaps": swap.format(0 if quiet else 123),
            "/proc/cpuinfo": "" if quiet else "flags : fpu vme hypervisor\n",
        },
    )
    monkeypatch.setattr(os, "cpu_count", lambda: 4 if quiet else 1)
    monkeypatch.setattr(system.threading, "enumerate", lambda: [system.threading.main_thread()])
    words = (
        "has one CPU",
        "950 of 1000 ms",
        "governor of CPU 3 is powersave",
        "shares its core with CPU 1",
        "swap is in use",
        "virtual machine",
    )
    found = list(system.disturbances(3))
    assert len(found) == (0 if quiet else len(words))
    assert all(each in "\n".join(found) for each in words) or quiet


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
    assert setup._isolated_choices(allowed, cpus_of(isolated)) == wanted


def test_lists_of_processors() -> None:
    assert cpus_of("0-2,5\n") == {0, 1, 2, 5}
    assert cpus_of("\n") == cpus_of("(null)") == cpus_of("1-x") == set()


def thread(folder: Path, number: int, stat: str, cpus: str) -> None:
    place = folder / str(number) / "task" / str(number)
    place.mkdir(parents=True)
    (place / "stat").write_text(stat)
    (place / "status").write_text(f"Name: x\nCpus_allowed_list:\t{cpus}\n")


def test_competitors_are_pinned_real_time_programs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = "{} ({}) S 1 1 1 0 -1 {} " + "0 " * 30 + "{} 1 0"
    thread(tmp_path, 11, line.format(11, "an engine) (2", 0x400, 80), "3")
    thread(tmp_path, 12, line.format(12, "free", 0x400, 80), "0-3")
    thread(tmp_path, 13, line.format(13, "usual", 0x400, 0), "3")
    thread(tmp_path, 14, line.format(14, "migration/3", 0x200000, 99), "3")
    thread(tmp_path, 15, "damaged", "3")
    monkeypatch.setattr(system, "PROCESSES", tmp_path)
    (found,) = competitors()
    assert (found.process, found.priority, found.cpu) == (11, 80, 3)

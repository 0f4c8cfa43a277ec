"""A deployment is broken at every step, and nothing is ever lost.

Whatever happens, the controller has all old programs or all new ones, or `resume` ends with all new
and, tried from the same state, `rollback` with all old, byte for byte. What is not ours stays.
"""

import os
from dataclasses import dataclass, field
from functools import partial

import pytest

from assistant.base.diagnostics import Refused
from assistant.deploy import FileState
from tests.deploy.benches import BENCHES
from tests.deploy.children import child

resource = pytest.importorskip("resource", reason="no limits here")
pytestmark = pytest.mark.skipif(os.name == "nt", reason="processes are forked and killed")
STILL = 0.0
"""Seconds of patience: what is put back is tried once."""


@dataclass
class Tally:
    """Faults that were tried, and what they lost."""

    bench: object
    faults: int = 0
    ends: dict[str, int] = field(default_factory=dict)
    losses: list[str] = field(default_factory=list)

    def judge(self, what, done=None):
        """Looks at what a fault has left, and at what resume and rollback make of it."""
        self.faults += 1
        try:
            end = judged(self.bench, done)
        except AssertionError as lost:
            self.losses.append(f"{what}: {lost}")
            end = "lost"
        self.ends[end] = self.ends.get(end, 0) + 1

    def told(self):
        ends = ", ".join(f"{count} {end}" for end, count in sorted(self.ends.items()))
        return f"{self.faults} faults, {len(self.losses)} losses ({ends})"


def judged(bench, done):
    """What the state is, in a word; raises AssertionError for a loss."""
    state = bench.quiet()
    now = bench.programs()
    untouched = {name: now.get(name) for name in bench.old if name not in bench.names}
    assert all(data == bench.old[name] for name, data in untouched.items()), "foreign programs"
    if done is not None and done.ok:
        assert now == bench.new, "said to be installed"
    elif done is not None and FileState.UNKNOWN not in done.states.values():
        assert now == bench.old, "said to be put back"
    resumed = ended(bench.resume)
    if resumed is None:  # nothing is open
        assert now in (bench.old, bench.new), (
            f"neither old nor new, and nothing open: {differ(bench)}"
        )
        again = bench.deploy(patience=3.0)
        assert again.ok, [finding.message for finding in again.findings]
    elif not resumed.states:  # somebody held it who needed it no more
        assert now in (bench.old, bench.new), f"neither old nor new, and freed: {differ(bench)}"
        assert bench.programs() == now
        again = bench.deploy(patience=3.0)
        assert again.ok, [finding.message for finding in again.findings]
    else:
        assert resumed.ok, [finding.message for finding in resumed.findings]
    assert bench.programs() == bench.new, differ(bench)
    assert bench.rests() == [], bench.rests()
    bench.restore(state)
    if resumed is None and now == bench.old:
        return "as before"
    back = ended(bench.rollback)
    assert back is not None, "nothing to take back"
    assert back.ok, [finding.message for finding in back.findings]
    assert bench.programs() == bench.old, differ(bench)
    assert bench.rests() == [], bench.rests()
    if resumed is not None and resumed.states:
        assert bench.record() == bench.start[0].get("robot-assistant.json"), "the record"
        return "open"
    return "freed" if resumed is not None else "as wanted"


def ended(act):
    """What it ended as, None if there was nothing to do."""
    try:
        return act()
    except Refused as refused:
        codes = [finding.code for finding in refused.findings]
        assert codes in (["DP212"], ["DP213"]), [f.message for f in refused.findings]
        return None


def differ(bench):
    now = bench.programs()
    words = []
    for name in sorted({*now, *bench.new}):
        data = now.get(name)
        kinds = [kind for kind in ("old", "new") if getattr(bench, kind).get(name) == data]
        words.append(f"{name}: {' and '.join(kinds) or 'strange'}")
    return "; ".join(words)


def attempt(bench):
    """A deployment in this process; None where it could not be planned."""
    try:
        return bench.deploy(STILL)
    except Refused:
        return None


def measured(bench):
    """Bytes that had passed after each piece of a deployment that nothing happens to, and steps."""
    bench.proxy.arm()
    done = attempt(bench)
    assert done is not None and done.ok, done
    bench.proxy.calm()
    marks, steps = bench.proxy.marks, bench.proxy.steps
    bench.restore(bench.start)
    return marks, steps


def places(marks, every):
    """Behind each piece, and in the middle of those that hold something; one of `every`."""
    found = set()
    for before, behind in zip([0, *marks], marks, strict=False):
        found |= {behind, (before + behind) // 2} - {0}
        if behind - before > 200:  # of a transfer
            found |= set(range(before + 50, behind, 97))
    return sorted(found)[::every]


def cut(bench, tally, every):
    marks, _ = measured(bench)
    for number, place in enumerate(places(marks[:-2], every)):
        again = number % 2 == 0
        bench.restore(bench.start)
        bench.proxy.arm(cut=place, again=again)
        done = attempt(bench)
        bench.proxy.arm()
        tally.judge(f"cut after {place} bytes, {'once' if again else 'for good'}", done)


def refuse(bench, tally, every):
    _, steps = measured(bench)
    for step, answer in bench.refused(steps)[::every]:
        bench.restore(bench.start)
        with bench.refusing(step, answer):
            done = attempt(bench)
        tally.judge(f"step {step} answered {answer[:20]!r}", done)


def kill(bench, tally, every):
    bench.proxy.arm()
    bench.proxy.arm(step=-1, pid=0)
    done = attempt(bench)
    assert done is not None and done.ok
    steps = bench.proxy.steps
    tried = [(step, behind) for step in range(steps) for behind in (False, True)]
    for step, behind in tried[::every]:
        bench.restore(bench.start)
        with child(bench) as process:
            bench.proxy.arm(step=step, pid=process.pid, behind=behind)
        bench.proxy.arm()
        tally.judge(f"killed at step {step}, {'behind' if behind else 'before'} it")


def full_here(bench, tally, every):
    """No file of this computer gets longer than so many bytes: as if the disk were full there."""
    for most in range(0, 1600, every):
        bench.restore(bench.start)
        with child(bench, most):
            bench.proxy.arm()
        tally.judge(f"no file here longer than {most} bytes")
    for most in range(70, 900, every):
        bench.restore(bench.start)
        with child(bench) as process:
            bench.proxy.arm(act=partial(limit, bench, process.pid, most))
        bench.proxy.arm()
        tally.judge(f"once it is begun no file here longer than {most} bytes")


def limit(bench, pid, most, _step):
    """From the beginning of the second journal on; its lines are cut off then."""
    if any(bench.history.glob("*/0002/journal.jsonl")):
        _, hard = resource.prlimit(pid, resource.RLIMIT_FSIZE)
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (most, hard))


def full_there(bench, tally, every):
    if bench.room_for is None:
        pytest.skip("its disk is as large as that of this computer")
    for size in range(0, 16000, every):
        bench.restore(bench.start)
        with bench.room_for(size):
            done = attempt(bench)
        tally.judge(f"room for {size} bytes there", done)


FAULTS = {
    "cut": cut,
    "refuse": refuse,
    "kill": kill,
    "full here": full_here,
    "full there": full_there,
}


@pytest.fixture
def bench(request, tmp_path):
    with BENCHES[request.param](tmp_path).ready() as bench:
        yield bench


QUICK = ("irc5 ftp", "cr", "proftpd", "vsftpd", "never replaces", "sftp")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("bench", QUICK, indirect=True)
def test_a_deployment_that_died_is_finished_and_is_taken_back(bench):
    marks, _ = measured(bench)
    tally = Tally(bench)
    bench.restore(bench.start)
    bench.proxy.arm(cut=marks[len(marks) * 2 // 3], again=False)
    done = attempt(bench)
    bench.proxy.arm()
    tally.judge("cut", done)
    assert tally.losses == []
    assert tally.ends == {"open": 1}


EVERY = {"cut": 60, "refuse": 60, "kill": 40, "full here": 400, "full there": 5000}
"""Which of the places that there are is tried; 1 is every byte, step or size."""


@pytest.mark.slow
@pytest.mark.parametrize("name", BENCHES)
def test_nothing_is_lost_whatever_happens(name, tmp_path, tell):
    """Some 50 faults of each controller; a server that is not installed is left out."""
    faults, losses, lines = 0, [], []
    for fault, act in FAULTS.items():
        told = f"{name}, {fault}: "
        try:
            tally = tried(BENCHES[name], tmp_path / fault.replace(" ", "_"), act, EVERY[fault])
        except pytest.skip.Exception as skipped:
            told += str(skipped)
        else:
            told += tally.told()
            faults += tally.faults
            losses += tally.losses
        lines.append(told)
    tell("\n".join(lines))
    assert losses == []
    assert faults >= 25 or not faults  # none where its server is not installed


def tried(make, folder, act, every):
    folder.mkdir()
    with make(folder).ready() as bench:
        tally = Tally(bench)
        act(bench, tally, every)
    return tally

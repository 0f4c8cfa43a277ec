"""Deployments to many virtual controllers at once, through the real clients."""

import signal
import threading
from contextlib import ExitStack

import pytest

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.deploy import EVERY, Cell, FileState, Halt, deploy_to_all
from assistant.virtual.cr import VirtualCr

PROGRAM = "10 OVRD 50\r\n20 DLY {}\r\n30 END\r\n"
OLD, NEW = PROGRAM.format(1), PROGRAM.format(2)


class Cells:
    """Virtual controllers `cell1`, `cell2` …, each with the programs A and B."""

    def __init__(self, folder, stack):
        self.folder, self.stack = folder, stack
        self.there = {}
        self.reports = {}
        self.files = []
        for name in ("a", "b"):
            file = folder / f"{name}.prg"
            file.write_bytes(NEW.encode())
            self.files.append(file)

    def add(self, count=1):
        for _ in range(count):
            name = f"cell{len(self.there) + 1}"

            def report(line, name=name):
                self.reports.get(name, lambda line: None)(line)

            controller = VirtualCr(report=report)
            self.there[name] = self.stack.enter_context(controller)
            with self.client(name) as client:
                client.write("A", OLD.encode())
                client.write("B", OLD.encode())
        return self

    def client(self, name):
        return connect(self.there[name].address, timeout=10)

    def cell(self, name, files=None, replace=(EVERY,)):
        client = self.client(name)

        def plan():
            return deploying.plan(
                files or self.files, client, replace=replace, history=self.history
            )

        return Cell(name, client.address, plan)

    def journals(self):
        return [one for place in self.history.iterdir() for one in deploying.journals(place)]

    @property
    def history(self):
        return self.folder / "kept"

    def deploy(self, cells=None, **options):
        chosen = cells or [self.cell(name) for name in self.there]
        given = {"history": self.history, "patience": 0.0, **options}
        return deploy_to_all(chosen, **given)

    def texts(self, name):
        return [self.there[name].text(program) for program in ("A", "B")]


@pytest.fixture
def cells(tmp_path):
    with ExitStack() as stack:
        yield Cells(tmp_path, stack)


def states(rollout):
    return [str(one.state) for one in rollout.outcomes]


def codes(outcome):
    return [finding.code for finding in outcome.findings]


def test_all_are_deployed_to_in_their_order(cells):
    cells.add(4)
    rollout = cells.deploy(parallel=3)
    assert rollout.ok and rollout.status == 0
    assert [one.name for one in rollout.outcomes] == ["cell1", "cell2", "cell3", "cell4"]
    assert all(cells.texts(name) == [NEW, NEW] for name in cells.there)
    assert rollout.summary == "4 of 4 controllers are done"
    assert len({one.deployment.folder for one in rollout.outcomes}) == 4


def test_some_are_deployed_to_at_once_and_no_more_than_the_limit(cells):
    cells.add(3)
    lock, open_now, most = threading.Lock(), set(), []
    two = threading.Barrier(2)

    def reporting(name):
        def report(line):
            if "DLY 2" not in line:
                return
            with lock:
                first = name not in open_now
                open_now.add(name)
                most.append(len(open_now))
            if first and name != "cell3":
                two.wait(10)  # a broken barrier fails: these two have to be there together

        return report

    for name in cells.there:
        cells.reports[name] = reporting(name)
    inner = [cells.cell(name) for name in cells.there]
    rollout = cells.deploy(inner, parallel=2)
    assert rollout.ok and not two.broken and most


def test_one_after_another_with_a_limit_of_one(cells):
    cells.add(3)
    seen = []
    for name in cells.there:
        cells.reports[name] = lambda line, name=name: seen.append(name) if "DLY 2" in line else None
    assert cells.deploy(parallel=1).ok
    assert list(dict.fromkeys(seen)) == ["cell1", "cell2", "cell3"]
    assert seen == sorted(seen)


def drop(cells, name):
    """The controller of a cell gives a program back otherwise than it was sent."""
    store = cells.there[name].state.store

    def report(line):
        if "SAVE" in line and "A" in store and store["A"].steps.get(20) == "20 DLY 2":
            store["A"].steps[20] = "20 DLY 9"

    cells.reports[name] = report


def test_nothing_else_is_begun_if_the_canary_fails(cells):
    cells.add(3)
    drop(cells, "cell2")
    rollout = cells.deploy(canary="cell2", parallel=3)
    assert states(rollout) == ["not begun", "failed", "not begun"]
    assert all(cells.texts(name) == [OLD, OLD] for name in cells.there)
    first, second, third = rollout.outcomes
    assert (
        codes(first) == codes(third) == ["DP403"] and "`cell2` failed" in first.findings[0].message
    )
    assert codes(second)[0] == "DP202" and second.deployment.states["A"] is FileState.PUT_BACK
    assert "failed: cell2; not begun: cell1, cell3" in rollout.summary and rollout.status == 1


def test_the_canary_is_done_before_another_is_begun(cells):
    cells.add(3)
    seen = []
    for name in cells.there:
        cells.reports[name] = lambda line, name=name: seen.append(name) if "DLY 2" in line else None
    assert cells.deploy(canary="cell3", parallel=3).ok
    assert seen[0] == "cell3" and "cell3" not in seen[len([n for n in seen if n == "cell3"]) :]


def test_after_a_failure_no_more_are_begun(cells):
    cells.add(4)
    drop(cells, "cell2")
    rollout = cells.deploy(parallel=1)
    assert states(rollout) == ["done", "failed", "not begun", "not begun"]
    assert cells.texts("cell1") == [NEW, NEW]
    assert all(cells.texts(name) == [OLD, OLD] for name in ("cell2", "cell3", "cell4"))
    again = cells.deploy([cells.cell(n, replace=()) for n in ("cell1",)])
    assert again.ok and set(again.outcomes[0].deployment.states.values()) == {FileState.SAME}


def test_those_under_way_go_on_to_their_end_after_a_failure(cells):
    """The first one to fail waits until the second has begun, which ends well all the same."""
    cells.add(3)
    begun, failed = threading.Event(), threading.Event()
    drop(cells, "cell1")
    mischief = cells.reports["cell1"]

    def first(line):
        if "SAVE" in line:
            begun.wait(10)
        mischief(line)
        failed.set()

    def second(line):
        if "DLY 2" in line:
            begun.set()
            failed.wait(10)

    cells.reports |= {"cell1": first, "cell2": second}
    rollout = cells.deploy(parallel=2)
    assert states(rollout)[:2] == ["failed", "done"]
    assert cells.texts("cell1") == [OLD, OLD] and cells.texts("cell2") == [NEW, NEW]


def test_a_cell_that_cannot_be_planned_keeps_all_from_beginning(cells):
    cells.add(3)
    bad = cells.folder / "bad.prg"
    bad.write_bytes(b"10 MOV ((\r\n20 END\r\n")
    chosen = [cells.cell("cell1"), cells.cell("cell2", [bad]), cells.cell("cell3")]
    rollout = cells.deploy(chosen)
    assert states(rollout) == ["not begun", "failed", "not begun"]
    assert rollout.outcomes[1].findings and rollout.outcomes[1].plan is None
    assert all(cells.texts(name) == [OLD, OLD] for name in cells.there)
    assert not cells.history.exists()


def test_a_conflict_or_a_controller_that_is_away_keeps_all_from_beginning(cells):
    cells.add(3)
    rollout = cells.deploy([cells.cell("cell1"), cells.cell("cell2", replace=())])
    assert states(rollout) == ["not begun", "failed"]
    assert codes(rollout.outcomes[1]) == ["DP204", "DP204"]
    away = cells.cell("cell3")
    cells.there["cell3"].stop()
    rollout = cells.deploy([cells.cell("cell1"), away])
    assert states(rollout) == ["not begun", "failed"] and codes(rollout.outcomes[1]) == ["CN201"]
    assert cells.texts("cell1") == [OLD, OLD]


def test_cells_of_one_controller_follow_each_other(cells):
    """Both of one record: what the second leaves has the programs of the first in it."""
    cells.add(1)
    a, b = cells.files
    two = [cells.cell("cell1", [a]), cells.cell("cell1", [b])]
    rollout = cells.deploy(two, parallel=2)
    assert rollout.ok and cells.texts("cell1") == [NEW, NEW]
    (place,) = cells.history.iterdir()
    last = deploying.journals(place)[-1]
    assert last.number == 2 and set(last.record.programs) == {"A", "B"}


def test_a_canary_that_nobody_knows(cells):
    cells.add(1)
    with pytest.raises(Refused) as refused:
        cells.deploy(canary="cell7")
    assert [f.code for f in refused.value.findings] == ["DP401"]
    assert refused.value.exit_status == 2 and "cell1" in refused.value.findings[0].cure


def test_an_end_in_order_takes_back_those_under_way(cells):
    """All wait for each other in the first program; the end is asked for before the second."""
    cells.add(3)
    halt, both = Halt(), threading.Barrier(2)

    def report(line):
        if "DLY 2" in line and not halt.asked:
            both.wait(10)
            halt.asked = True

    cells.reports |= {"cell1": report, "cell2": report}
    rollout = cells.deploy(parallel=2, halt=halt)
    assert states(rollout) == ["failed", "failed", "not begun"]
    assert [codes(one)[0] for one in rollout.outcomes] == ["DP304", "DP304", "DP402"]
    assert all(cells.texts(name) == [OLD, OLD] for name in cells.there)
    assert not any(journal.open for journal in cells.journals())


def test_ctrl_c_is_raised_when_all_have_ended_in_order(cells):
    cells.add(2)
    both = threading.Barrier(2)
    told = threading.Event()

    def report(line):
        if "DLY 2" in line and not told.is_set():
            if both.wait(10) == 0:
                signal.raise_signal(signal.SIGINT)
            told.wait(10)

    def handler(number, frame):
        told.set()
        raise KeyboardInterrupt

    cells.reports |= {"cell1": report, "cell2": report}
    before = signal.signal(signal.SIGINT, handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            cells.deploy(parallel=2)
    finally:
        signal.signal(signal.SIGINT, before)
    assert not any(journal.open for journal in cells.journals())
    for name in cells.there:
        assert len(set(cells.texts(name))) == 1

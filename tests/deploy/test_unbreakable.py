"""Damaged histories, made-up archives, claims that were left, signals, two at once."""

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import zipfile

import pytest

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused
from assistant.deploy import FileState
from assistant.deploy.history import place_of
from assistant.deploy.lock import lock_on_this_computer
from assistant.deploy.site import Site
from tests.deploy.benches import CrBench, Irc5Bench, files_below, make_files
from tests.deploy.children import child
from tests.wire import Wire


@pytest.fixture
def bench(tmp_path):
    with Irc5Bench(tmp_path).ready() as bench:
        yield bench


@pytest.fixture
def died(bench):
    """With a deployment whose line was cut for good while its second program was sent."""
    bench.proxy.arm()
    assert bench.deploy().ok
    bench.proxy.calm()
    marks = bench.proxy.marks
    bench.restore(bench.start)
    bench.proxy.arm(cut=marks[len(marks) * 2 // 3], again=False)
    assert FileState.UNKNOWN in bench.deploy().states.values()
    bench.proxy.arm()
    return bench


def codes(findings):
    return [finding.code for finding in findings]


def refused(act):
    with pytest.raises(Refused) as caught:
        act()
    return codes(caught.value.findings)


def place(bench):
    return place_of(bench.client().address, bench.history)


def test_a_line_of_the_journal_that_is_cut_off_hides_none_behind_it(died):
    steps = place(died) / "0002" / "journal.jsonl"
    steps.write_bytes(steps.read_bytes() + b'{"time": "2026", "st\xff')
    assert codes(died.deploy().findings) == ["DP208"]
    assert died.rollback().ok and died.programs() == died.old
    assert json.loads(steps.read_bytes().splitlines()[-1])["step"] == "taken back"
    assert died.deploy().ok


@pytest.mark.parametrize("journal", [None, b"", b'{"time": "2026-01-01", "st'])
def test_a_journal_without_a_line_means_that_nothing_was_begun(bench, journal):
    """As a full disk leaves it: the first line is there before any program is touched."""
    shutil.copytree(place(bench) / "0001", place(bench) / "0002")
    steps = place(bench) / "0002" / "journal.jsonl"
    steps.unlink()
    if journal is not None:
        steps.write_bytes(journal)
    assert bench.deploy().ok and bench.programs() == bench.new
    assert deploying.journals(place(bench))[1].result == "not begun"
    assert bench.rollback().ok and bench.programs() == bench.old


def test_a_journal_whose_lines_are_damaged_is_open(died):
    (place(died) / "0002" / "journal.jsonl").write_bytes(b"\xff\n")
    assert codes(died.deploy().findings) == ["DP208"]


@pytest.fixture
def dying(bench, monkeypatch):
    """Its line is lost for good while the second program is sent."""
    monkeypatch.setattr("assistant.deploy.site.BETWEEN", 0.1)
    bench.proxy.arm()
    assert bench.deploy().ok
    bench.proxy.calm()
    marks = bench.proxy.marks
    bench.restore(bench.start)
    bench.proxy.arm(cut=marks[len(marks) * 2 // 3], again=False)
    bench.told = []
    return bench


def dead(dying, **options):
    plan = deploying.plan(dying.local, dying.client(), history=dying.history)
    return deploying.deploy(
        plan, history=dying.history, files_only=True, tell=dying.told.append, **options
    )


def test_a_line_that_is_lost_is_reported_at_once_and_has_one_patience_for_all(dying, monkeypatch):
    connect, tries = Site.reconnect, []

    def counted(site):
        tries.append(codes(dying.told))
        connect(site)

    monkeypatch.setattr(Site, "reconnect", counted)
    done = dead(dying, patience=0.5)
    assert not done.ok and FileState.UNKNOWN in done.states.values()
    assert codes(dying.told) == ["DP305"] and "0.5 s" in dying.told[0].message
    assert all(told == ["DP305"] for told in tries), "it was not reported before it was tried"
    assert 1 <= len(tries) <= 8
    dying.proxy.calm()
    assert dying.rollback().ok and dying.programs() == dying.old


def test_a_wait_for_a_lost_line_can_be_left(dying):
    done = dead(dying, patience=600.0, leave=lambda: True)
    assert "DP306" in codes(done.findings)
    dying.proxy.calm()
    assert codes(dying.deploy().findings) == ["DP208"]
    assert dying.rollback().ok and dying.programs() == dying.old


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="it has no such signals")
def test_ctrl_c_leaves_a_deployment_open_whose_line_is_lost(dying):
    process = subprocess.Popen(
        [sys.executable, "-m", "assistant", *dying.arguments()],
        env={**os.environ, "ROBOT_ASSISTANT_PASSWORD": dying.password},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    said = ""
    for line in process.stderr:
        said += line
        if "DP305" in said:
            break
    over = threading.Event()

    def interrupt():
        while not over.wait(0.1):
            process.send_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    _, err = process.communicate(timeout=60)
    over.set()
    thread.join()
    assert "DP306" in err and "Traceback" not in err, said + err
    dying.proxy.calm()
    assert dying.rollback().ok and dying.programs() == dying.old


def test_a_journal_that_is_damaged_is_not_believed(died):
    before = died.programs()
    for file in ("before/1-a.mod", "after/2-b.mod", "record.json", "programs.json"):
        damaged = place(died) / "0002" / file
        whole = damaged.read_bytes()
        damaged.write_bytes(whole[:-3] + b"9\n}")
        assert refused(died.rollback) == refused(died.resume) == ["DP203"], file
        damaged.write_bytes(whole)
    assert died.programs() == before
    assert died.rollback().ok


def test_an_old_deployment_that_is_damaged_is_in_nobodys_way(bench):
    (place(bench) / "0001" / "programs.json").write_bytes(b"{")
    (place(bench) / ".newdead").mkdir()
    assert bench.deploy().ok and not (place(bench) / ".newdead").exists()
    assert bench.rollback().ok and bench.programs() == bench.old


def hold(bench, name="20260101T000000Z-abcdef"):
    """The claim of somebody else."""
    claim = {"deployment": name, "who": "ann@office", "time": "2026-01-01"}
    (bench.home / "robot-assistant.lock").mkdir()
    if name:
        (bench.home / "robot-assistant.claim.json").write_text(json.dumps(claim))


def test_a_claim_of_who_changed_nothing_is_freed(bench, monkeypatch):
    monkeypatch.setattr("assistant.deploy.lock.BETWEEN", 0.01)
    for name in ("", "20260101T000000Z-abcdef"):
        for act in (bench.resume, bench.rollback):
            hold(bench, name)
            assert codes(bench.deploy().findings) == ["DP210"]
            done = act()
            assert codes(done.findings) == ["DP226"] and done.states == {}
            assert bench.programs() == bench.old and bench.rests() == []
    assert bench.deploy().ok


def archive(files, **options):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", **options) as made:
        for name, content in files:
            made.writestr(name, content)
    return data.getvalue()


def made_up(record, rows, *more):
    return archive([("record.json", record), ("programs.json", json.dumps(rows)), *more])


def row(name, path):
    return {"name": name, "before": {"file": None, "loaded": None},
            "after": {"file": path, "loaded": None}, "sha256": {}}  # fmt: skip


ROWS = {
    "out of the folder": [row("a.mod", "../../../../a.mod")],
    "no digest": [row("a.mod", "after/1-a.mod")],
    "a name that is a path": [row("../a.mod", "after/1-a.mod")],
    "a name of Windows": [row("a.mod ", "after/1-a.mod")],
    "no rows": {"name": "a.mod"},
    "no text": [row(7, "after/1-a.mod")],
}


def evil(record):
    """Archives that a controller might give, for a deployment of that record."""
    bomb = archive([("record.json", record), ("after/1-a", bytes(3_000_000))], compression=8)
    long = archive([("record.json", b" " * 2_000_000)], compression=8)
    yield from (b"", b"PK", b"x" * 1000, bomb, bomb[: len(bomb) // 2], long)
    yield archive([("record.json", record)])
    yield archive([("record.json", record), ("RECORD.json", record), ("programs.json", "[")])
    yield archive([("record.json", record), ("programs.json", "[" * 100_000)])
    yield archive([("record.json", record), ("programs.json", "[]")], compression=14)
    yield from (made_up(record, rows, ("after/1-a.mod", b"x")) for rows in ROWS.values())


def test_an_archive_that_somebody_made_up_does_nothing(bench, tmp_path, monkeypatch):
    monkeypatch.setattr("assistant.deploy.history.MOST_ARCHIVE_BYTES", 2_500_000)
    record = (place(bench) / "0001" / "record.json").read_bytes()
    bench.history = tmp_path / "elsewhere"
    hold(bench, json.loads(record)["name"])
    before = files_below(tmp_path)
    for data in evil(record):
        (bench.home / "robot-assistant.zip").write_bytes(data)
        assert refused(bench.resume) == ["DP203"], data[:60]
        changed = {n for n, d in files_below(tmp_path).items() if before.get(n, b"?") != d}
        assert changed <= {
            "home/robot-assistant.zip",
            "elsewhere",
            f"elsewhere/{place(bench).name}",
        }


def test_another_computer_goes_on_and_the_first_one_is_told(died, tmp_path):
    first = died.history
    died.history = tmp_path / "elsewhere"
    assert died.resume().ok and died.programs() == died.new
    died.local[0].write_bytes(died.source("a.mod", 3, 0))
    assert died.deploy().ok
    before = died.programs()
    died.history = first
    assert refused(died.rollback) == ["DP216"] and died.programs() == before
    assert died.deploy().ok, "it is not held for open any more"


def test_what_somebody_else_named_like_a_rest_stays(died):
    make_files(died.home, {**files_below(died.home), "b.mod~": b"kept", "~b.mod": b"MODU"})
    assert died.resume().ok
    assert (died.home / "b.mod~").read_bytes() == b"kept" and not (died.home / "~b.mod").exists()


def test_a_rest_that_is_ours_goes(died):
    make_files(died.home, {**files_below(died.home), "b.mod~": died.old["b.mod"]})
    assert died.rollback().ok and died.rests() == []


def test_a_second_process_is_told_that_there_is_one(died):
    with lock_on_this_computer(place(died)):
        assert codes(died.deploy().findings) == ["DP209"]
        assert refused(died.rollback) == refused(died.resume) == ["DP209"]


def test_a_record_that_was_changed_makes_everything_a_conflict(bench):
    file = bench.home / "robot-assistant.json"
    file.write_bytes(file.read_bytes().replace(b"a.mod", b"z.mod"))
    plan = deploying.plan(bench.local, bench.client(), history=bench.history)
    assert "DP221" in codes(plan.notes) and len(plan.conflicts) == 2


def test_a_program_that_is_open_elsewhere_is_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr("assistant.deploy.site.BETWEEN", 0.01)
    with CrBench(tmp_path).ready() as bench, Wire(bench.real_port) as other:
        other.ask("1;1;LOAD=B")
        refusals = []

        def freed(step):
            """Somebody else closes it once it has been asked for twice."""
            if step > 3 and not refusals:
                refusals.append(other.ask("1;1;NEW"))

        bench.proxy.arm(act=freed)
        plan = deploying.plan(bench.local, bench.client(), history=bench.history)
        assert refusals == ["QoK"] and [file.name for file in plan.changes] == ["A", "B", "C"]


ENDS = [(signal.SIGTERM,), (signal.SIGHUP,), (signal.SIGINT, signal.SIGINT, signal.SIGTERM)]


@pytest.mark.skipif(os.name == "nt", reason="it has no such signals")
@pytest.mark.parametrize("signals", ENDS, ids=["SIGTERM", "SIGHUP", "Ctrl-C twice"])
def test_what_ends_it_from_outside_leaves_everything_as_it_was(bench, signals):
    left = list(signals)

    def end(step):
        """The first while the second program is sent, the others while they are put back."""
        there = (bench.home / "a.mod").read_bytes() == bench.new["a.mod"]
        if left and (there or len(left) < len(signals)):
            os.kill(process.pid, left.pop(0))

    with child(bench) as process:
        bench.proxy.arm(act=end)
    assert process.exitcode == 128 + signals[0] and left == []
    bench.proxy.calm()
    assert bench.programs() == bench.old and bench.rests() == []
    assert bench.record() == bench.start[0]["robot-assistant.json"]
    assert refused(bench.resume) == ["DP212"]


def test_a_history_that_is_gone_is_no_reason_for_a_mixture(died):
    shutil.rmtree(died.history)
    assert died.rollback().ok, "the controller has kept it"
    assert died.programs() == died.old and died.rests() == []


def test_a_plan_is_not_carried_out_behind_another_deployment(bench):
    """Its record would forget what the other one brought."""
    one, other = (
        deploying.plan([file], bench.client(), history=bench.history) for file in bench.local[:2]
    )
    assert deploying.deploy(one, history=bench.history, files_only=True).ok
    before = bench.programs()
    done = deploying.deploy(other, history=bench.history, files_only=True)
    assert codes(done.findings) == ["DP217"] and bench.programs() == before
    assert bench.rests() == []
    assert bench.deploy().ok

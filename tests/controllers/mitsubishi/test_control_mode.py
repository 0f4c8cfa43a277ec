"""Data link control mode against the programs themselves, run by the interpreter on real lines."""

import math
from contextlib import ExitStack, contextmanager

import numpy as np
import pytest

from assistant import languages
from assistant.base.diagnostics import Refused, Severity
from assistant.controllers.mitsubishi.control_mode import FORM, ControlMode, program_texts
from assistant.controllers.mitsubishi.data_link import DataLink, Rate
from assistant.controllers.rules import Lost
from assistant.virtual.events import Moved
from tests.controllers.mitsubishi.running import Running, samples, serial, tcp

LIMITS = [(-150, 150), (-60, 120), (-110, 120), (-1, 1), (-90, 90), (-200, 200)]
"""Of the RV-2AJ, which lacks the fourth axis."""


def points(*turns):
    return [(turn, 0.0, 90.0, 0.0, 90.0, 0.0) for turn in turns]


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@contextmanager
def cell(one=tcp, two=tcp, **settings):
    """The programs run; what leads to their lines, as a serial port takes no parity here."""
    with ExitStack() as open_:
        (com1, control), (com2, status) = (open_.enter_context(kind()) for kind in (one, two))
        lines = {"COM1:": com1, "COM2:": com2}
        running = open_.enter_context(Running(samples("datalink"), lines, **settings))
        rate = Rate(19200, "none", 1)
        yield running, *(DataLink(target, timeout=5, rate=rate) for target in (control, status))


def turned(running):
    """J1 of each motion, once all slots stand and the run is over."""
    running.stopped()
    run = running.ended()
    moved = [event for event in run.events if isinstance(event, Moved)]
    return [event.joints[0] for event in moved if event.joints is not None]


@pytest.mark.parametrize("level", [4, 5, 6])
def test_the_programs_are_valid_in_every_version(level):
    language = languages.get(f"melfa-basic-{level}")
    files = [language.parse(text.decode("latin-1")) for text in program_texts().values()]
    findings = [*language.check(files), *(found for file in files for found in file.findings)]
    assert len(files) == 3 and not [f for f in findings if f.severity is not Severity.INFO]


@pytest.mark.parametrize(
    ("one", "two"), [(serial, tcp), pytest.param(tcp, serial, marks=pytest.mark.slow)]
)
def test_points_on_one_line_while_the_status_comes_on_the_other(one, two, tmp_path):
    goals = list(range(0, 50, 2))
    told = []
    with cell(one, two) as (running, control, status):
        with ControlMode(None, control, status, limits=LIMITS) as mode:
            mode.follow(points(*goals), progress=lambda done, count: told.append((done, count)))
            mode.follow(points(10, 20))
            assert mode.status.taken == 27
        assert turned(running) == [*goals, 10, 20]
        assert running.states == ["waits", "reset", "reset"]
    assert told == sorted(told) and told[-1] == (25, 25)
    seconds, taken = mode.recording.column("seconds"), mode.recording.column("M_04")
    assert (np.diff(seconds) >= 0).all() and (np.diff(taken) >= 0).all() and taken[-1] >= 27
    assert mode.recording.column("J_FBC").shape == (len(seconds), 8)
    mode.recording.save(tmp_path / "run.csv")
    assert len((tmp_path / "run.csv").read_text().splitlines()) == len(seconds) + 1


def test_the_arm_does_not_stop_between_the_points():
    """As long as points wait, the tool is never slower than a good part of its speed."""
    with cell(timed=True) as (running, control, status):
        with ControlMode(None, control, status, limits=LIMITS) as mode:
            mode.follow(points(*range(0, 61, 10)))
        assert turned(running)[-1] == 60
    turn, speed = mode.recording.column("J_CURR")[:, 0], mode.recording.column("M_RSPD(3)")
    within = speed[(turn > 5) & (turn < 55)]
    assert len(within) > 5 and within.min() > 0.5 * within.max() > 0


def test_no_more_points_wait_than_may_run_on():
    with cell(timed=True) as (running, control, status):
        with ControlMode(None, control, status, limits=LIMITS, ahead=2) as mode:
            seen = []
            mode.follow(
                points(*range(0, 30, 5)),
                progress=lambda done, _: seen.append(mode._sent - mode.status.taken),
            )
        assert 1 <= max(seen) <= 2
        assert turned(running) == list(range(0, 30, 5))


# --------------------------------------------------------------------------------- refused


@pytest.mark.parametrize(
    ("joints", "code"),
    [
        *(
            ([], "CN622"),
            ([1, 2], "CN622"),
            ([(1, 2), (3,)], "CN622"),
            ([(1j,) * 6], "CN622"),
            ([(0,) * 5], "CN622"),
            (points(math.nan), "CN621"),
        ),
        *((points(0, math.inf), "CN622"), (points(0, math.nan), "CN622")),
        *((points(0, 150.001), "CN621"), (points(-151), "CN621"), (points(0, 30), "CN623")),
    ],
)
def test_points_that_cannot_be_are_refused_before_anything_is_sent(joints, code):
    mode = ControlMode(None, "127.0.0.1:1", "127.0.0.1:1", limits=LIMITS, most_step=20)
    if joints == points(math.nan):
        joints = [(math.nan, 0, 121, 0, 0, 0)]
    with pytest.raises(Refused) as refused:
        mode.follow(joints)
    assert codes(refused) == [code]


def test_nothing_follows_without_a_session():
    mode = ControlMode(None, "127.0.0.1:1", "127.0.0.1:1", limits=LIMITS)
    with pytest.raises(Lost) as lost:
        mode.follow(points(1))
    assert codes(lost) == ["CN614"]
    with (
        pytest.raises(Lost) as lost,
        ControlMode(None, "127.0.0.1:1", DataLink("127.0.0.1:1", timeout=0.2), limits=LIMITS),
    ):
        pass
    assert codes(lost) == ["CN613"]


@pytest.mark.parametrize("limits", [[], [(1, 2, 3)], [(1, 1)], [(0, math.nan)], [(0, 1)] * 9])
def test_limits_that_are_none_are_refused(limits):
    with pytest.raises(Refused) as refused:
        ControlMode(None, "127.0.0.1:1", "127.0.0.1:1", limits=limits)
    assert codes(refused) == ["CN622"]


def test_a_first_point_that_is_far_away_is_refused_if_steps_are_bounded():
    with cell() as (running, control, status):
        mode = ControlMode(None, control, status, limits=LIMITS, most_step=20)
        with pytest.raises(Refused) as refused, mode:
            mode.follow(points(30, 40))
        assert codes(refused) == ["CN623"] and "point 1" in str(refused.value)
        assert turned(running) == []


# ---------------------------------------------------------------------------------- faults


def test_an_interrupt_stops_the_arm_on_its_way():
    with cell(timed=True) as (running, control, status):
        mode = ControlMode(None, control, status, limits=LIMITS)
        with pytest.raises(KeyboardInterrupt), mode:

            def press(done, count):
                if done:
                    raise KeyboardInterrupt

            mode.follow(points(*range(0, 150, 10)), progress=press)
        running.stopped()
        assert mode.recording.column("J_CURR")[-1, 0] < 140


def test_a_control_line_that_is_cut_stops_all():
    with cell(timed=True) as (running, control, status):
        mode = ControlMode(None, control, status, limits=LIMITS)
        with pytest.raises(Lost) as lost, mode:
            mode.follow(
                points(*range(0, 150, 5)), progress=lambda done, _: done and control.close()
            )
        assert codes(lost) == ["CN614"] and "the programs were stopped" in str(lost.value)
        running.stopped()


def answers(line, data):
    """A program that says something else on the status line."""
    program = f'10 OPEN "COM2:" AS #2\n20 PRINT #2,"READY"\n30 INPUT #2,M1\n{data}\n90 END\n'
    return {"A": program}, {"COM2:": line}


@pytest.mark.parametrize(
    ("data", "code"),
    [
        ("40 DLY 3", "CN625"),  # silence
        ('40 PRINT #2,"1|2|3"\n50 DLY 1', "CN615"),
        ('40 PRINT #2,"END"\n50 DLY 1', "CN627"),
        ('40 DLY 0.02\n50 PRINT #2,"READY"\n60 GOTO 40', "CN625"),
        ("40 CLOSE #2\n50 DLY 1", "CN614"),
    ],
)
def test_a_status_line_that_is_none_is_found(data, code):
    with ExitStack() as open_:
        (_, control), (com2, target) = (open_.enter_context(tcp()) for _ in range(2))
        open_.enter_context(Running(*answers(com2, data)))
        silence = 0.2 if code == "CN625" else 1.5  # what comes may come late on a busy machine
        status = DataLink(target, timeout=silence)
        mode = ControlMode(None, control, status, limits=LIMITS, silence=silence, timeout=8)
        with pytest.raises(Lost) as lost, mode:
            mode.follow(points(1))
        assert codes(lost) == [code]


def test_an_error_on_the_controller_ends_it():
    """A point that the arm cannot reach, as the limits that were stated are too wide."""
    with cell(timed=True) as (_, control, status):
        status.timeout = 0.3
        mode = ControlMode(None, control, status, limits=[(-999, 999)] * 6, silence=0.3)
        with pytest.raises(Lost) as lost, mode:
            mode.follow(points(0, 10, 500))
        assert codes(lost)[0] in ("CN614", "CN625")


def test_the_form_of_the_stream_is_that_of_the_program():
    printed = next(line for line in samples("datalink")["DATALINK"].splitlines() if "J_FBC" in line)
    fields = printed.partition("PRINT #2,")[2].split(',"|",')
    assert tuple(fields) == FORM.names

"""Deployments to controllers whose positions stand in their programs, and which run slots."""

import pytest

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused
from assistant.controllers.address import parse
from assistant.controllers.mitsubishi.cr import Cr
from assistant.controllers.states import Identity
from assistant.deploy import Change, FileState
from assistant.virtual.cr import VirtualCr

SEAM = "10 MOV P1\r\n20 DLY {}\r\n30 END\r\nP1=(+250.00,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)\r\n"
AROUND = '5 M1=0\r\n10 DLY 0.1\r\n20 IF M1=1 THEN CALLP "SEAM"\r\n30 GOTO 10\r\n40 END\r\n'


@pytest.fixture
def cr():
    with VirtualCr() as controller:
        yield controller


@pytest.fixture
def client(cr):
    return Cr(parse(cr.address), timeout=10, pace=0.0)


BESIDE = '5 M1=0\r\n10 DLY 0.1\r\n20 IF M1=1 THEN XRUN 2,"SEAM"\r\n30 GOTO 10\r\n40 END\r\n'


def put(folder, name, text):
    path = folder / f"{name.lower()}.prg"
    path.write_text(text, newline="")
    return path


def installed(client, folder, *files):
    done = deploying.deploy(plan(client, folder, *files), history=folder / "h", patience=0.0)
    assert done.ok, done.findings


def plan(client, folder, *files, **options):
    return deploying.plan(files, client, history=folder / "h", **options)


def deploy(planned, folder):
    return deploying.deploy(planned, history=folder / "h", patience=0.0)


def codes(findings):
    return [finding.code for finding in findings]


def test_a_taught_position_is_a_conflict_with_its_difference(cr, client, tmp_path):
    seam = put(tmp_path, "SEAM", SEAM.format(1))
    installed(client, tmp_path, seam)
    taught = "(251.50,0.00,449.90,0.00,180.00,0.00)(6,0)"
    with client:
        client.set_variable("P1", taught, "SEAM")
    seam.write_text(SEAM.format(2), newline="")
    planned = plan(client, tmp_path, seam)
    assert planned.files[0].change is Change.CONFLICT
    assert "-P1=(+251.50" in planned.files[0].diff and "+P1=(+250.00" in planned.files[0].diff
    held = cr.text("SEAM")
    assert codes(deploy(planned, tmp_path).findings) == ["DP204"] and cr.text("SEAM") == held
    again = plan(client, tmp_path, seam, replace=["SEAM"])
    assert deploy(again, tmp_path).ok and "+250.00" in cr.text("SEAM")
    assert deploying.rollback(client, history=tmp_path / "h").ok and cr.text("SEAM") == held


@pytest.mark.parametrize(("name", "text"), [("SEAM", AROUND), ("SEAM", BESIDE), ("AROUND", AROUND)])
def test_a_program_that_runs_or_is_used_is_not_replaced(cr, client, tmp_path, name, text):
    seam = put(tmp_path, "SEAM", "10 DLY 1\r\n20 END\r\n")
    around = put(tmp_path, "AROUND", text)
    other = put(tmp_path, "OTHER", SEAM.format(1))
    installed(client, tmp_path, seam, around)
    changed = put(tmp_path, name, cr.text(name).replace("10 ", "10 DLY 0.2\r\n11 ", 1))
    with client:
        client.load("AROUND")
        client.start(forever=True)
    before = {one: cr.text(one) for one in cr.names()}
    done = deploy(plan(client, tmp_path, other, changed), tmp_path)
    assert codes(done.findings) == ["DP206"]
    assert ("uses it" in done.findings[0].message) is (name == "SEAM")
    assert {one: cr.text(one) for one in cr.names()} == before
    with pytest.raises(Refused) as refused:
        deploying.rollback(client, history=tmp_path / "h", patience=0.0)
    assert set(codes(refused.value.findings)) == {"DP206"}
    installed(client, tmp_path, other)


def test_a_program_that_is_protected_there_stays_and_the_others_come_back(cr, client, tmp_path):
    files = [put(tmp_path, name, SEAM.format(1)) for name in ("ONE", "SEAM")]
    installed(client, tmp_path, *files)
    with client:
        client.protect("SEAM", lines=True)
    before = [cr.text(name) for name in cr.names()]
    files = [put(tmp_path, name, SEAM.format(2)) for name in ("ONE", "SEAM")]
    done = deploy(plan(client, tmp_path, *files), tmp_path)
    assert "4240" in done.findings[0].message
    assert done.states == {"ONE": FileState.PUT_BACK, "SEAM": FileState.UNTOUCHED}
    assert [cr.text(name) for name in cr.names()] == before


def test_another_robot_is_refused(client, tmp_path):
    seam = put(tmp_path, "SEAM", SEAM.format(1))
    with pytest.raises(Refused) as refused:
        plan(client, tmp_path, seam, meant=Identity(robot="rv-4frl"))
    assert codes(refused.value.findings) == ["DP233"]
    assert not plan(client, tmp_path, seam, meant=Identity(robot="Mitsubishi RV-2AJ")).notes

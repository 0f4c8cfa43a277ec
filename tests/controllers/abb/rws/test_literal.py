"""Each operation with what it asks and what the references say is answered, in both dialects.

Answers: the samples of ABB's reference of Robot Web Services 1.0, and what the tests of
ichbinmeraj/abb-rws-client hold as captured from RobotWare 6.16 and 7.21.
"""

import json
from dataclasses import replace

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers.states import State, TaskState
from tests.controllers.abb.rws.literal import FAULTS, ONE, POSITION, START, TEXT, TWO
from tests.controllers.abb.rws.peer import Rws1, Rws2, refusal

PROGRAM = "progpath=HOME/seam.pgf&loadmode=replace"
ACCESS = "EIO/EIO_SIGNAL/doGripper/Access"
CASES = {
    "identify": (
        lambda c: (c.identify().robot, c.identify().controller, c.identify().serial),
        ("IRB 1200", "IRC5_7", "12-34567"), [], [],
    ),
    "lamps": (
        lambda c: replace(c.state(), tasks=()), State("automatic", True, override=70), [], [],
    ),
    "tasks": (lambda c: c.state().tasks, (TaskState("T_ROB1", "Seam", 14, False),), [], []),
    "position": (lambda c: c.position(), POSITION, [], []),
    "log": (lambda c: c.log(2), FAULTS, [], []),
    "newest": (lambda c: c.log(1), FAULTS[:1], [], []),
    "modules": (lambda c: c.modules(), ("BASE", "Seam"), [], []),
    "module text": (lambda c: c.module_text("m", "T_ROB1"), TEXT.encode("latin-1"), [], []),
    "variable": (lambda c: c.variable("reg1", "user", "T_ROB1"), "42.5", [], []),
    "variable of an unnamed module": (
        lambda c: c.variable("reg1"), "42.5",
        [("/rw/rapid/symbols?action=search-symbols",
          "view=block&vartyp=any&symtyp=any&recursive=TRUE&skipshared=FALSE&onlyused=FALSE&stack=0&posl=0"
          "&posc=0&blockurl=RAPID/T_ROB1&regexp=%5Ereg1$")],
        [("/rw/rapid/symbols/search",
          "view=block&vartyp=any&symtyp=any&recursive=TRUE&blockurl=RAPID/T_ROB1&regexp=%5Ereg1$")],
    ),
    "set variable": (
        lambda c: c.set_variable("reg1", "[[1,2],3]", "user"), None,
        [("/rw/rapid/symbol/data?action=validate", "task=T_ROB1&value=[[1,2],3]&datatype=num"),
         ("/rw/mastership/rapid?action=request", ""),
         ("/rw/rapid/symbol/data/RAPID/T_ROB1/user/reg1?action=set", "value=[[1,2],3]"),
         ("/rw/mastership/rapid?action=release", "")],
        [("/rw/rapid/symbol/RAPID/T_ROB1/data?action=validate", "value=[[1,2],3]&dattyp=num"),
         ("/rw/mastership/edit/request", ""),
         ("/rw/rapid/symbol/RAPID/T_ROB1/user/reg1/data", "value=[[1,2],3]"),
         ("/rw/mastership/edit/release", "")],
    ),
    "load a module": (
        lambda c: c.load("seam.mod"), None,
        [("/rw/mastership/rapid?action=request", ""),
         ("/rw/rapid/tasks/T_ROB1?action=loadmod", "modulepath=$HOME/seam.mod&replace=true"),
         ("/rw/rapid/execution?action=resetpp", ""),
         ("/rw/mastership/rapid?action=release", "")],
        [("/rw/mastership/edit/request", ""),
         ("/rw/rapid/tasks/T_ROB1/loadmod", "modulepath=HOME/seam.mod&replace=true"),
         ("/rw/rapid/execution/resetpp", ""),
         ("/rw/mastership/edit/release", "")],
    ),
    "load a program": (
        lambda c: c.load("seam.pgf", "t_rob1"), None,
        [("/rw/mastership/rapid?action=request", ""),
         ("/rw/rapid/tasks/T_ROB1/program?action=loadprog", PROGRAM.replace("HOME", "$HOME")),
         ("/rw/rapid/execution?action=resetpp", ""),
         ("/rw/mastership/rapid?action=release", "")],
        [("/rw/mastership/edit/request", ""),
         ("/rw/rapid/tasks/T_ROB1/program/load", PROGRAM),
         ("/rw/rapid/execution/resetpp", ""),
         ("/rw/mastership/edit/release", "")],
    ),
    "unload": (
        lambda c: c.unload("Seam"), None,
        [("/rw/mastership/rapid?action=request", ""),
         ("/rw/rapid/tasks/T_ROB1?action=unloadmod", "module=Seam"),
         ("/rw/mastership/rapid?action=release", "")],
        [("/rw/mastership/edit/request", ""),
         ("/rw/rapid/tasks/T_ROB1/unloadmod", "module=Seam"),
         ("/rw/mastership/edit/release", "")],
    ),
    "start once": (
        lambda c: c.start(), None,
        [("/rw/rapid/execution?action=start", f"{START}&cycle=once")],
        [("/rw/rapid/execution/start", f"{START}&cycle=once")],
    ),
    "start forever": (
        lambda c: c.start("T_ROB1", forever=True), None,
        [("/rw/rapid/execution?action=start", f"{START}&cycle=forever")],
        [("/rw/rapid/execution/start", f"{START}&cycle=forever")],
    ),
    "stop": (
        lambda c: c.stop(), None,
        [("/rw/rapid/execution?action=stop", "stopmode=stop")],
        [("/rw/rapid/execution/stop", "stopmode=stop&usetsp=normal")],
    ),
    "motors": (
        lambda c: c.motors(True), None,
        [("/rw/panel/ctrlstate?action=setctrlstate", "ctrl-state=motoron")],
        [("/rw/panel/ctrl-state", "ctrl-state=motoron")],
    ),
    "override": (
        lambda c: c.set_override(30), None,
        [("/rw/panel/speedratio?action=setspeedratio", "speed-ratio=30")],
        [("/rw/mastership/edit/request", ""),
         ("/rw/panel/speedratio?action=setspeedratio", "speed-ratio=30"),
         ("/rw/mastership/edit/release", "")],
    ),
    "signal": (
        lambda c: c.outputs(["doGripper"]), {"doGripper": 1.0},
        [("/rw/iosystem/signals?action=signal-search", "name=doGripper")],
        [("/rw/iosystem/signals/signal-search", "name=doGripper")],
    ),
    "all inputs": (lambda c: c.inputs([]), {"aiForce": 3.25}, [], []),
    "set output": (
        lambda c: c.set_output("doGripper", 0), None,
        [("/rw/iosystem/signals?action=signal-search", "name=doGripper"),
         ("/rw/iosystem/signals/Local/DRV_1/doGripper?action=set", "lvalue=0")],
        [("/rw/iosystem/signals/signal-search", "name=doGripper"),
         ("/rw/iosystem/signals/Local/DRV_1/doGripper/set-value", "lvalue=0")],
    ),
    "parameters": (lambda c: c.parameters([ACCESS]), {ACCESS: "Default"}, [], []),
    "parameters of a type": (
        lambda c: c.parameters(["EIO/EIO_SIGNAL"]),
        {"EIO/EIO_SIGNAL/doGripper/Name": "doGripper", ACCESS: "Default"}, [], [],
    ),
    "set parameter": (
        lambda c: c.set_parameter(ACCESS, "All"), None,
        [("/rw/mastership/cfg?action=request", ""),
         ("/rw/cfg/EIO/EIO_SIGNAL/instances/doGripper?action=set", "Access=All"),
         ("/rw/mastership/cfg?action=release", "")],
        [("/rw/mastership/edit/request", ""),
         ("/rw/cfg/EIO/EIO_SIGNAL/instances/doGripper", "Access=[All,1]"),
         ("/rw/mastership/edit/release", "")],
    ),
    "reset": (lambda c: c.reset(), None, [], []),
}  # fmt: skip
"""What is done, what comes back, and path and form of all that is written on the way."""


@pytest.fixture(scope="module")
def peers():
    with Rws1(ONE) as one, Rws2(TWO) as two, one.connect() as first, two.connect() as second:
        yield {1: (one, first), 2: (two, second)}


@pytest.mark.parametrize("dialect", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_the_documented_requests_and_answers(peers, name, dialect):
    peer, client = peers[dialect]
    act, result, *written = CASES[name]
    peer.log.clear()
    client._signals._places.clear()
    assert act(client) == result
    assert [(path, body) for _, path, body in peer.asked()] == written[dialect - 1]


HELD = "a.cpp[547] Requested resource is held by someone else"
ORG = "x.cpp[1] ERROR: C:\\y.cpp[6544]: org_code: -508;"
NONE = "rws_resource_panel.cpp[1688] The user does not have required mastership"
REFUSALS = {
    (1, 403, -1073445862, HELD, "CN301"): "release the",
    (1, 403, -1073445881, "C:\\B\\rws_iosystem.cpp[3554] Rejected", "CN301"): "grant",
    (1, 400, -1073442809, ORG, "CN301"): "stop the programs",
    (2, 403, -1073445859, NONE, "CN301"): "release the",
    (2, 403, -1073445867, "rapi_uas_resource.cpp[2995] Not allowed", "CN301"): "grant",
    (2, 500, None, "", "CN205"): "what it says",
    (1, 405, None, "", "CN205"): "what it says",
}


@pytest.mark.parametrize("case", REFUSALS, ids=str)
def test_refusals_come_with_number_text_and_cure(case):
    dialect, status, number, message, code = case
    body = refusal(number, message) if number else ""
    kind, path = ((Rws1, "POST /rw/panel/ctrlstate"), (Rws2, "POST /rw/panel/ctrl-state"))[
        dialect - 1
    ]
    with kind({path: (status, body)}) as peer, pytest.raises(Refused) as refused:
        peer.files[f"{peer.home}/a"] = b""
        with peer.connect() as client:
            client.motors(True)
    (finding,) = refused.value.findings
    assert finding.code == code and REFUSALS[case] in finding.cure
    assert ".cpp" not in finding.message and "icode" not in finding.message
    assert str(number or status) in finding.message


def test_an_answer_as_json_error():
    told = {"status": {"code": -1073445879, "msg": "a.cpp[2] Invalid action"}}
    answers = {"POST /rw/panel/ctrlstate": (400, json.dumps({"_embedded": told}))}
    with Rws1(answers) as peer, peer.connect() as client, pytest.raises(Refused) as refused:
        client.motors(False)
    assert "-1073445879 (Invalid action)" in refused.value.findings[0].message

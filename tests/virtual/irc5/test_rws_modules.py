"""Modules of the virtual IRC5 and their data: loaded, read and changed over RWS."""

from __future__ import annotations

from urllib.parse import unquote

import pytest

from tests.virtual.irc5.programs import ended, module, ready, start


def test_data_is_read_and_written_while_it_runs_and_while_it_stands(robot):
    data = (
        "PERS bool go := FALSE;",
        'VAR string said := "no";',
        "PERS pos place := [1,2,3];",
        "CONST num pi2 := 6.28;",
        "VAR num list{3} := [1,2,3];",
    )
    ready(robot, "WaitUntil go;", 'said := "go";', "place.x := 7.5;", data=data)
    start(robot)
    assert robot.value("T_ROB1/Work/said") == '"no"'
    assert robot.set("T_ROB1/Work/go", "TRUE").status == 204
    ended(robot)
    assert robot.value("T_ROB1/Work/said") == '"go"'
    assert robot.value("T_ROB1/Work/place") == "[7.5,2,3]"
    assert robot.set("T_ROB1/Work/place", "[4,5,6]").status == 204
    assert robot.value("T_ROB1/place") == "[4,5,6]"
    assert robot.set("T_ROB1/Work/list", "[4,5,6]").status == 204
    assert robot.value("T_ROB1/Work/list") == "[4,5,6]"
    for symbol, value in (("place", "[4,5]"), ("go", "1"), ("said", "bare"), ("list", "[1]")):
        assert robot.set(f"T_ROB1/Work/{symbol}", value).status == 400
    assert robot.set("T_ROB1/Work/pi2", "3").status == 403
    assert robot.value("T_ROB1/Work/place") == "[4,5,6]"
    assert robot.value("T_ROB1/BASE/tool0").startswith("[TRUE,[[0,0,0],[1,0,0,0]]")


def test_symbols_are_found_by_what_they_are(robot):
    ready(robot, "n := 1;", data=("PERS num n := 0;", "VAR pos p;", "LOCAL CONST num c := 1;"))
    found = robot.post(
        "/rw/rapid/symbols?action=search-symbols",
        "/rw/rapid/symbols/search",
        view="block",
        blockurl="RAPID/T_ROB1/Work",
        symtyp="any",
    ).items()
    assert {(row["_type"], row["name"], row["dattyp"], row["local"]) for row in found} == {
        ("rap-symproppers-li", "n", "num", "false"),
        ("rap-sympropvar-li", "p", "pos", "false"),
        ("rap-sympropconst-li", "c", "num", "true"),
    }
    path = robot.either(
        "/rw/rapid/symbol/properties/RAPID/T_ROB1/Work/n",
        "/rw/rapid/symbol/RAPID/T_ROB1/Work/n/properties",
    )
    assert robot.client.get(path).items("rap-symproppers")[0]["symtyp"] == "per"
    one, two = (
        "/rw/rapid/symbol/data?action=validate",
        "/rw/rapid/symbol/RAPID/T_ROB1/data?action=validate",
    )
    for value, status in (("[1,2,3]", 204), ("[1,2]", 400), ("x", 400)):
        form = {"task": "T_ROB1", "value": value, robot.either("datatype", "dattyp"): "pos"}
        assert robot.post(one, two, **form).status == status


def test_the_text_of_a_module_has_the_values_of_now(robot):
    ready(robot, "n := 42;", data=("PERS num n := 0;",))
    start(robot)
    ended(robot)
    path = robot.either(
        "/rw/rapid/modules/Work?resource=module-text&task=T_ROB1",
        "/rw/rapid/tasks/T_ROB1/modules/Work/text",
    )
    text = robot.client.get(path).items("rap-module-text")[0]["module-text"]
    said = unquote(text) if robot.client.dialect == 1 else text
    assert said == module("n := 42;", data=("PERS num n := 42;",))
    saved = robot.post(
        "/rw/rapid/modules/Work?task=T_ROB1&action=save",
        "/rw/rapid/tasks/T_ROB1/modules/Work/save",
        name="kept",
        path=robot.either("$HOME", "HOME:"),
    )
    assert saved.status == 204
    kept = robot.client.send("GET", robot.file(robot.either("kept.mod", "kept.modx")))
    assert kept.text == said


def test_modules_come_and_go(robot):
    robot.take()
    assert robot.load("work.mod", module("other;")).status == 204
    assert robot.load("work.mod", module("other;")).code == -1073442809  # loaded already
    second = "MODULE Second\nPERS num done := 0;\nPROC other()\ndone := 1;\nENDPROC\nENDMODULE\n"
    assert robot.load("second.mod", second).status == 204
    listed = robot.client.get(
        robot.either("/rw/rapid/modules?task=T_ROB1", "/rw/rapid/tasks/T_ROB1/modules")
    ).items("rap-module-info-li")
    assert [row["name"] for row in listed] == ["Work", "Second"]
    robot.motors()
    robot.execution("resetpp")
    start(robot)
    ended(robot)
    assert robot.value("T_ROB1/Second/done") == "1"
    one, two = "/rw/rapid/tasks/T_ROB1?action=unloadmod", "/rw/rapid/tasks/T_ROB1/unloadmod"
    assert robot.post(one, two, module="Work").status == 204
    assert robot.value("T_ROB1/Second/done") == "1"  # PERS data of what stays keeps its value
    assert robot.execution("resetpp").code == -1073442809  # no main any more


@pytest.mark.parametrize("text", [module("n := ;"), module("n := 1;").replace("ENDPROC", ""), ""])
def test_a_module_with_errors_is_not_loaded(robot, text):
    robot.take()
    robot.load("work.mod", module("WaitTime 1;"))
    refused = robot.load("work.mod", text, "true")
    assert refused.status == 400 and "work.mod" in refused.text
    assert 40160 in robot.codes()
    robot.motors()
    assert robot.execution("resetpp").status == 204  # what was there still is


def test_a_program_file_names_what_is_loaded(robot):
    robot.take()
    robot.load("old.mod", module("WaitTime 1;", name="Old"))
    for name in ("a", "b"):
        text = module("b;") if name == "a" else "MODULE B\nPROC b()\nENDPROC\nENDMODULE\n"
        robot.client.put(robot.file(f"{name}.mod"), text.encode())
    listed = b"<Program><Module>a.mod</Module><Module>b.mod</Module></Program>"
    robot.client.put(robot.file("prog.pgf"), listed)
    one, two = (
        "/rw/rapid/tasks/T_ROB1/program?action=loadprog",
        "/rw/rapid/tasks/T_ROB1/program/load",
    )
    path = robot.either("$HOME/prog.pgf", "HOME/prog.pgf")
    assert robot.post(one, two, progpath=path).status == 204
    listed = robot.client.get(
        robot.either("/rw/rapid/modules", "/rw/rapid/tasks/T_ROB1/modules")
    ).items("rap-module-info-li")
    assert [row["name"] for row in listed] == ["Work", "B"]

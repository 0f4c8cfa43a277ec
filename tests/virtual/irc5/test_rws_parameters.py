"""System parameters of the virtual IRC5 over RWS, and in its backups."""

from __future__ import annotations

import pytest

PATH = "/rw/cfg/EIO/EIO_SIGNAL/instances"
FILE = b"""EIO:CFG_1.0:6:1::
#
EIO_SIGNAL:

      -Name "do_new" -SignalType "DO" -Label "a - b" \\
      -Access "ReadOnly" -Safe
#
EIO_CROSS:

      -Res "do_new" -Act1 "di_part" -Delay -2.5
"""


@pytest.fixture(autouse=True)
def as_it_was(irc5):
    signals = irc5.cabinet.parameters.values["EIO"]["EIO_SIGNAL"]
    before = {name: dict(row) for name, row in signals.items()}
    yield
    irc5.cabinet.parameters.values["EIO"] = {"EIO_SIGNAL": before}


def attributes(robot, name):
    row = next(r for r in robot.client.get(PATH).items() if r["_title"] == name)
    assert row["_type"] == "cfg-dt-instance-li"
    kind = robot.either("cfg-ia-t-li", "cfg-ia-t")
    assert {one["_type"] for one in row["attrib"]} == {kind}
    return {one["_title"]: one["value"] for one in row["attrib"]}


def test_instances_are_read_and_set(robot):
    listed = robot.client.get("/rw/cfg").items("cfg-domain-li")
    assert [row["_title"] for row in listed] == ["EIO", "MMC", "MOC", "PROC", "SIO", "SYS"]
    assert [row["_title"] for row in robot.client.get("/rw/cfg/SYS").items()] == ["CAB_TASKS"]
    assert attributes(robot, "do_lamp") == {
        "Name": "do_lamp",
        "SignalType": "DO",
        "Device": "DRV_1",
    }
    robot.take("cfg")
    value = robot.either("DRV_2", "[DRV_2,1]")
    path = f"{PATH}/do_lamp"
    assert robot.post(f"{path}?action=set", path, Device=value).status == 204
    assert attributes(robot, "do_lamp")["Device"] == "DRV_2"
    for name in ("Nothing", "Name"):
        assert robot.post(f"{path}?action=set", path, **{name: value}).status == 400
    wrong = {"/rw/cfg/NONE": 404, "/rw/cfg/EIO/NONE/instances": 400, f"{PATH}/none": 404}
    assert {path: robot.client.get(path).status for path in wrong} == wrong


def test_files_of_parameters_are_loaded_and_saved(robot, fresh):
    robot.take("cfg")
    robot.client.put(robot.file("new.cfg"), FILE)
    form = {"filepath": robot.either("$HOME/new.cfg", "HOME/new.cfg")}
    for how, status in (("add", 204), ("add", 400), ("replace", 204), ("none", 400)):
        form["action-type"] = how
        assert robot.post("/rw/cfg?action=load", "/rw/cfg/load", **form).status == status
    assert attributes(robot, "do_new") == {
        "Name": "do_new",
        "SignalType": "DO",
        "Label": "a - b",
        "Access": "ReadOnly",
        "Safe": "TRUE",
    }
    cross = fresh.cabinet.parameters.values["EIO"]["EIO_CROSS"]
    assert cross == {"0": {"Res": "do_new", "Act1": "di_part", "Delay": "-2.5"}}
    saved = {"filepath": robot.either("$HOME/saved.cfg", "HOME/saved.cfg")}
    assert robot.post("/rw/cfg/EIO?action=saveas", "/rw/cfg/EIO/saveas", **saved).status == 204
    before = fresh.cabinet.parameters.values["EIO"]
    text = robot.client.send("GET", robot.file("saved.cfg")).text
    fresh.cabinet.parameters.values["EIO"] = {}
    fresh.cabinet.parameters.load(text, "replace")
    assert fresh.cabinet.parameters.values["EIO"] == before
    robot.client.put(robot.file("new.cfg"), b"no parameters")
    form["action-type"] = "replace"
    assert robot.post("/rw/cfg?action=load", "/rw/cfg/load", **form).status == 400


def test_a_restore_brings_parameters_back(robot, fresh):
    robot.take("cfg")
    robot.take("rapid")
    place = robot.either("/fileservice/$BACKUP/p1", "/fileservice/BACKUP/p2")
    made = robot.post("/ctrl/backup?action=backup", "/ctrl/backup/create", backup=place)
    assert made.status == 202
    assert '-Name "do_lamp"' in robot.client.send("GET", f"{place}/SYSPAR/EIO.cfg").text
    fresh.cabinet.parameters.values["EIO"]["EIO_SIGNAL"].clear()
    back = robot.post("/ctrl/backup?action=restore", "/ctrl/backup/restore", backup=place)
    assert back.status == 202
    assert attributes(robot, "do_lamp")["Device"] == "DRV_1"

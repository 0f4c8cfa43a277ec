"""The virtual controllers of a project: deployed to, ended, and there again."""

import json
import subprocess
import sys

import pytest

from assistant import deploy
from assistant.base.diagnostics import Refused
from assistant.controllers import connect, named
from assistant.project import Target, build, project_of, targets_of
from tests.project.conftest import CELLS, Home, module

SERIAL = CELLS.replace('"rv-2aj"', '"rv-2aj"\n', 1).replace(
    '"irb1200-7-0.7"', '"irb1200-7-0.7"\nserial = "1200-500001"', 1
)
PROGRAM = "1 MOV P1\n2 END\nP1=(+100.00,+0.00,+300.00,+0.00,+180.00,+0.00)(7,0)\n"


@pytest.fixture
def both(home: Home) -> Home:
    home.put("seam.mod", module("seam"))
    home.put("seam.prg", PROGRAM)
    home.put(
        "assistant.toml",
        SERIAL + '[targets.cell1]\nprograms = ["seam.mod"]\nload = true\n'
        '[targets.cell2]\nprograms = ["seam.prg"]\n',
    )
    build(project_of(), jobs=1)
    return home


def deployed(target: Target) -> list[deploy.Change]:
    with target.opened() as controller:
        plan = deploy.plan(
            target.files(),
            controller,
            task=target.task,
            load=target.load,
            history=target.history,
        )
        assert deploy.deploy(plan, history=target.history).ok
        return [file.change for file in plan.files]


@pytest.mark.parametrize("number", [0, 1])
def test_what_is_deployed_is_there_for_the_next_command(both, number):
    target = targets_of()[number]
    assert deployed(target) == [deploy.Change.NEW]
    assert deployed(target) == [deploy.Change.SAME]
    histories = [folder.name for folder in target.history.iterdir()]
    assert histories == [f"virtual_cell{number + 1}"]  # whatever port it had


def test_memory_that_is_lost_is_loaded_again(both):
    target = targets_of()[0]
    deployed(target)
    memory = both.folder / ".robot-assistant/virtual/cell1/memory.json"
    rows = json.loads(memory.read_text())
    assert [(row["name"], row["file"]) for row in rows] == [("seam", "seam.mod")]
    for damaged in ("", "[{}]", "3", json.dumps([{**rows[0], "text": "MODULE x("}])):
        memory.write_text(damaged)
        with target.opened() as controller, controller:
            assert controller.loaded(module("seam").encode()) is None
    assert json.loads(memory.read_text()) == []


def test_it_tells_the_number_that_the_project_gives_it(both):
    with targets_of()[0].opened() as controller, controller:
        assert controller.identify().serial == "1200-500001"


def test_it_is_refused_where_nobody_starts_it(both):
    with pytest.raises(Refused, match="runs only as long") as caught:
        connect("cell1")
    assert caught.value.exit_status == 2
    assert named("cell1").virtual == "irc5"


def test_a_robot_of_its_own_file_cannot_be_virtual(both):
    both.put("mine.toml", "")
    text = (both.folder / "assistant.toml").read_text().replace('"rv-2aj"', '"mine.toml"')
    both.put("assistant.toml", text)
    with pytest.raises(Refused, match="no robot of the catalogue"), targets_of()[1].opened():
        raise AssertionError("it was started")


def test_an_address_that_is_no_virtual_controller(both):
    text = (both.folder / "assistant.toml").read_text().replace("virtual:cr", "virtual:crx")
    both.put("assistant.toml", text)
    with pytest.raises(Refused) as caught:
        targets_of()
    assert [(finding.code, finding.line) for finding in caught.value.findings] == [("CN118", 8)]


KILLED = """
import os, pathlib, sys
from assistant import deploy
from assistant.project import targets_of

target = targets_of()[int(sys.argv[1])]
with target.opened() as controller:
    plan = deploy.plan(target.files(), controller, load=target.load, history=target.history)
    assert deploy.deploy(plan, history=target.history).ok
    os._exit(9)
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1])
def test_what_was_deployed_survives_a_killed_process(both, number):
    done = subprocess.run([sys.executable, "-c", KILLED, str(number)], timeout=60)
    assert done.returncode == 9
    assert deployed(targets_of()[number]) == [deploy.Change.SAME]

"""Whole programs looked at in a process apart: the same findings, and nobody waits for them."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from assistant.editing import service
from assistant.editing.checker import Checker
from assistant.editing.service import Change, Document, Place, Range, Workspace

SAMPLES = Path(__file__).parent.parent.parent / "samples"
WRONG = """MODULE Wrong
    CONST robtarget pOne:=[[380,0,420],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PROC main()
        MoveL pOne,v100,fine,tool0;
        MoveL pNone,v100,fine,tool0;
        MoveL pOne,v2OO,z10,tool0;
    ENDPROC
ENDMODULE
"""


@pytest.fixture
def checker():
    made = Checker()
    yield made
    made.close()


@pytest.fixture(scope="module")
def lasting():
    """Also of other tests, each with a path of its own."""
    made = Checker()
    yield made
    made.close()


def apart(workspace: Workspace, checker: Checker) -> Workspace:
    workspace.apart = checker.look
    return workspace


def typed(workspace: Workspace, path: str, text: str, *changes: Change) -> list[object]:
    """The findings of a document that is opened, settled, changed and settled again."""
    document = workspace.open(path, text)
    found: list[object] = [service.settled(document)]
    for version, change in enumerate(changes, 1):
        document = workspace.change(path, [change], version)
        found += [service.findings(document), service.settled(document)]
    return found


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("Wrong.mod", WRONG),
        ("gluing.mod", (SAMPLES / "rapid" / "gluing.mod").read_text()),
        ("two.prg", "1 Mov P1\n2 Mvs P2\n3 M1=\n4 End\n"),
        ("p.pseudo", "program p\n\nprocedure main\n  wait 1\nend\n"),
    ],
)
def test_findings_from_the_process_are_those_from_here(tmp_path, lasting, path, text):
    name = str(tmp_path / path)
    at = Range(Place(3, 8), Place(3, 8))
    changes = Change(at, "x"), Change(at, "("), Change(Range(Place(3, 8), Place(3, 10)), "")
    there = typed(apart(Workspace(), lasting), name, text, *changes)
    here = typed(Workspace(), name, text, *changes)
    shown = [[str(one) for one in found] for found in there]
    assert shown == [[str(one) for one in found] for found in here]


def test_a_process_that_dies_is_started_anew_and_one_that_is_closed_is_not(tmp_path, checker):
    workspace = apart(Workspace(), checker)
    wanted = [str(one) for one in service.settled(Workspace().open(str(tmp_path / "W.mod"), WRONG))]
    for act in (lambda: None, lambda: checker._worker._process.kill(), checker.close):
        act()
        workspace.close(str(tmp_path / "W.mod"))
        found = service.settled(workspace.open(str(tmp_path / "W.mod"), WRONG))
        assert [str(one) for one in found] == wanted
    assert checker._worker._process is None


def test_keys_and_requests_are_answered_while_a_whole_program_is_looked_at(tmp_path):
    workspace, path = Workspace(), str(tmp_path / "Wrong.mod")
    document = workspace.open(path, WRONG)
    known = service.settled(document)
    begun, go_on = threading.Event(), threading.Event()

    def look(_: Document, unseen):
        begun.set()
        assert go_on.wait(60)
        return

    workspace.apart = look
    changed = workspace.change(path, [Change(Range(Place(3, 8), Place(3, 8)), " ")], 1)
    thread = threading.Thread(target=service.settled, args=(changed,))
    thread.start()
    assert begun.wait(60)
    changed = workspace.change(path, [Change(Range(Place(3, 9), Place(3, 9)), " ")], 2)
    labels = {one.label for one in service.completions(changed, Place(3, 11))}
    assert "MoveL" in labels
    assert len(service.findings(changed)) == len(known)
    assert thread.is_alive()
    go_on.set()
    thread.join(60)
    assert not thread.is_alive()

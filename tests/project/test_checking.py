"""`check` of a project: sources, and what is made of them, on the robot of each target."""

import errno
import re

import pytest

from assistant.project import build, builds, project_of
from assistant.project.builds import check
from tests.project.conftest import Home, module, pseudo

FAR = """MODULE far
  CONST robtarget there := [[3000,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveL there, v100, fine, tool0;
  ENDPROC
ENDMODULE
"""


def found(home: Home) -> list[tuple[str, str]]:
    return [(finding.code, finding.path) for finding in check(project_of(), jobs=1).findings]


@pytest.fixture
def cell(home: Home) -> Home:
    home.put("waiting.pseudo", pseudo())
    home.put("hand/seam.mod", module("seam"))
    home.states(
        '[programs.waiting]\nsource = "waiting.pseudo"\n'
        '[targets.cell1]\nprograms = ["waiting", "hand/seam.mod"]\n'
    )
    return home


def test_a_project_in_order_and_nothing_is_written(cell):
    done = check(project_of(), jobs=1)
    assert (done.programs, done.findings, done.unreadable) == (2, (), False)
    assert not (cell.folder / "build").exists()
    assert list((cell.folder / ".robot-assistant").iterdir()) == []


def test_a_project_that_cannot_be_written_is_checked_as_any_other(cell, monkeypatch):
    cell.put("hand/seam.mod", FAR.replace("v100", "v123"))
    cell.put("assistant.toml", (cell.folder / "assistant.toml").read_text() + SEVERITY)
    expected = found(cell)
    assert {code for code, _ in expected} >= {"RB102"}
    before = sorted(cell.folder.rglob("*"))

    def refused(folder):
        raise OSError(errno.EROFS, "Read-only file system", str(folder))

    monkeypatch.setattr(builds, "scratch_folder", refused)
    assert found(cell) == expected
    assert sorted(cell.folder.rglob("*")) == before


SEVERITY = """
[severity]
RA204 = "off"
"""


def test_a_program_is_checked_for_the_robot_of_its_target(cell):
    cell.put("hand/seam.mod", FAR)
    assert "RB102" in [code for code, _ in found(cell)]
    cell.states('[targets.cell1]\nprograms = ["hand/seam.mod"]\n')
    assert ("RB102", "hand/seam.mod") in found(cell)


def test_the_programs_of_a_target_are_looked_at_together(cell):
    called = module("seam").replace('TPWrite "seam"', "go_other")
    cell.put("hand/seam.mod", called)
    (alone,) = found(cell)
    assert alone[1] == "hand/seam.mod"
    cell.put("hand/other.mod", module("other"))
    text = (cell.folder / "assistant.toml").read_text()
    cell.put("assistant.toml", text.replace('seam.mod"', 'seam.mod", "hand/other.mod"'))
    assert found(cell) == []


TURNING = """program turning

target a [400, 0, 400] [0, 0, 1, 0]
target b [402, 0, 400] [0, 0, 1, 0]
target c [402, 2, 400] [0, 0, 1, 0]

procedure main
  move joint a speed 100 mm/s blend fine
  move linear b speed 100 mm/s blend 50 mm
  move linear c speed 100 mm/s blend fine
end
"""


def test_what_is_made_tells_once_what_its_source_tells(cell):
    cell.put("waiting.pseudo", TURNING)
    text = (cell.folder / "assistant.toml").read_text()
    cell.put("assistant.toml", f'{text}[severity]\nCK322 = "warning"\n')
    assert found(cell) == [("CK322", "waiting.pseudo")]
    made = build(project_of(), jobs=1).programs[0].files[0].read_text()
    by_hand = made.replace("turning", "seam").replace("main", "go")
    cell.put("hand/seam.mod", re.sub(r"\b([abc])\b", r"\1_seam", by_hand))
    places = [finding.place for finding in check(project_of(), jobs=1).findings]
    assert places[0] == "main: 1 of 3 targets (b)"
    assert "go: 1 of 3 targets (b_seam)" in str(places[1])


def test_names_that_clash_on_the_controller(cell):
    cell.put("more/SEAM.mod", module("other"))
    text = (cell.folder / "assistant.toml").read_text()
    cell.put("assistant.toml", text.replace('seam.mod"', 'seam.mod", "more/SEAM.mod"'))
    assert "PR201" in [code for code, _ in found(cell)]


def test_severities_and_comments_of_the_project_count(cell):
    odd = FAR.replace("main", "weld").replace("3000", "400").replace("v100", "v25")
    cell.put("hand/seam.mod", odd)
    assert found(cell) == [("RA204", "hand/seam.mod")]
    text = (cell.folder / "assistant.toml").read_text()
    cell.put("assistant.toml", f'{text}[severity]\nRA204 = "off"\n')
    assert found(cell) == []
    cell.put("assistant.toml", text)
    cell.put("hand/seam.mod", odd.replace("tool0;", "tool0; ! assistant: ignore RA204"))
    done = check(project_of(), jobs=1)
    assert (done.findings, [one.code for one in done.ignored]) == ((), ["RA204"])


def test_a_source_that_cannot_be_compiled(cell):
    cell.put("waiting.pseudo", "program waiting\n\nprocedure main\n  wiat 1 s\nend\n")
    assert {path for _, path in found(cell)} == {"waiting.pseudo"}
    assert not build(project_of(), jobs=1).ok

"""What assistant.toml says of programs and targets, and how it is told what is wrong there."""

import pytest

from assistant.base.diagnostics import Refused
from assistant.project import project_of, targets_of
from tests.project.conftest import CELLS, Home, module, pseudo

WHOLE = """
[programs.waiting]
source = "sources/waiting.pseudo"
entry = "main"

[programs.other]
source = "sources/waiting.pseudo"
language = "melfa-basic-4"
robot = "arms/mine.toml"
most_targets = 100
frames = "product"

[targets.cell1]
programs = ["waiting", "hand/seam.mod"]
task = "T_ROB2"
load = true

[targets.second]
controller = "cell2"
programs = ["other"]

[deploy]
parallel = 4
canary = "second"
"""


@pytest.fixture
def whole(home: Home) -> Home:
    home.put("sources/waiting.pseudo", pseudo())
    home.put("hand/seam.mod", module("seam"))
    home.put("arms/mine.toml", "")
    home.states(WHOLE)
    return home


def refused(folder) -> list[tuple[str, int | None]]:
    with pytest.raises(Refused) as caught:
        project_of(folder)
    assert caught.value.exit_status == 2
    return [(finding.code, finding.line) for finding in caught.value.findings]


def line_of(home: Home, words: str) -> int:
    lines = (home.folder / "assistant.toml").read_text("utf-8").splitlines()
    return next(number for number, line in enumerate(lines, 1) if words in line)


def test_a_whole_project(whole):
    project = project_of(whole.folder / "sources")
    assert (project.folder, project.parallel, project.canary) == (whole.folder, 4, "second")
    waiting, other = project.programs["waiting"], project.programs["other"]
    assert (waiting.source, waiting.entry) == (whole.folder / "sources/waiting.pseudo", "main")
    assert (other.language, other.frames, other.most_targets) == ("melfa-basic-4", "product", 100)
    assert other.robot == str(whole.folder / "arms/mine.toml")
    first, second = targets_of(whole.folder)
    assert (first.name, first.task, first.load) == ("cell1", "T_ROB2", True)
    assert [one.name for one in first.place.recipes] == ["waiting", "hand/seam.mod"]
    assert (second.controller.name, second.controller.virtual) == ("cell2", "cr")
    assert second.history == whole.folder / ".robot-assistant" / "deployments"


def test_the_table_of_pyproject(home):
    home.put("waiting.pseudo", pseudo())
    text = f'{CELLS}[programs.a]\nsource = "waiting.pseudo"\n[targets.cell1]\nprograms = ["a"]\n'
    text = text.replace("[controllers", "[tool.robot-assistant.controllers")
    text = text.replace("[programs", "[tool.robot-assistant.programs")
    home.put("pyproject.toml", text.replace("[targets", "[tool.robot-assistant.targets"))
    (target,) = targets_of(home.folder)
    assert [one.name for one in target.place.recipes] == ["a"]


@pytest.mark.parametrize(
    ("right", "wrong", "code", "word"),
    [
        ("[targets.second]", "[target.second]", "CT302", "write `targets`"),
        ('source = "sources/waiting.pseudo"\nentry', "entry", "PR106", "source"),
        ('entry = "main"', 'entri = "main"', "CT302", "write `entry`"),
        ('entry = "main"', "entry = 3", "CT303", "text"),
        ('entry = "main"', 'process = "/etc/passwd"', "PR104", "outside"),
        ('entry = "main"', 'process = "../x.toml"', "PR104", "outside"),
        ('entry = "main"', 'process = "."', "PR104", "outside"),
        ('entry = "main"', 'process = "sources"', "PR105", "no file"),
        ('entry = "main"', 'cell = "../cell.toml"', "PR104", "outside"),
        ('entry = "main"', 'cell = "cell.toml"', "PR105", "no file"),
        ('entry = "main"', 'process = "sources/wating.pseudo"', "PR105", "sources/waiting.pseudo"),
        ('entry = "main"', 'robot = "irb1200-7-07"', "PR107", "irb1200-7-0.7"),
        ("most_targets = 100", "most_targets = 3", "CT303", "10 to"),
        ('"product"', '"factor"', "CT303", '"base" or "product"'),
        ('"melfa-basic-4"', '"rapid"', "PR110", "melfa-basic-4"),
        ('controller = "cell2"', 'controller = "cel2"', "PR107", "write `cell2`"),
        ('["other"]', '["othr"]', "PR107", "write `other`"),
        ('["other"]', "[]", "PR108", "second"),
        ('["other"]', '["hand/sem.mod"]', "PR105", "hand/seam.mod"),
        ('"T_ROB2"', '"T_ROB2;stop"', "CT303", "T_ROB1"),
        ("load = true", 'load = "yes"', "CT303", "true or false"),
        ('canary = "second"', 'canary = "secnd"', "PR107", "write `second`"),
        ("parallel = 4", "parallel = 0", "CT303", "1 to"),
        ("[programs.waiting]", '[programs."a b"]', "PR103", "letters"),
        ('controller = "cell2"', 'controller = "cell1"\ntask = "T_ROB2"', "PR109", "cell1"),
        ('"rv-2aj"', '"../mine.toml"', "PR104", "outside"),
        ('"rv-2aj"', '"rv-2ja"', "PR107", "write `rv-2a`"),
    ],
)
def test_what_is_wrong_is_said_at_its_place(whole, right, wrong, code, word):
    text = CELLS + WHOLE
    assert right in text
    whole.put("assistant.toml", text.replace(right, wrong, 1))
    with pytest.raises(Refused) as caught:
        project_of(whole.folder)
    finding = next(one for one in caught.value.findings if one.code == code)
    assert word in f"{finding.message} {finding.cure}"
    assert finding.line is not None and finding.path == str(whole.folder / "assistant.toml")
    assert caught.value.exit_status == 2


def test_a_link_out_of_the_project_is_refused(whole, tmp_path_factory):
    outside = tmp_path_factory.mktemp("outside") / "x.pseudo"
    outside.write_text(pseudo())
    (whole.folder / "sources/link.pseudo").symlink_to(outside)
    whole.states(WHOLE.replace("sources/waiting.pseudo", "sources/link.pseudo"))
    assert {code for code, _ in refused(whole.folder)} == {"PR104"}


@pytest.mark.parametrize("name", ["build", "build/cell1", ".robot-assistant"])
def test_nothing_is_written_through_a_link(whole, tmp_path_factory, name):
    (whole.folder / name).parent.mkdir(exist_ok=True)
    (whole.folder / name).symlink_to(tmp_path_factory.mktemp("outside"))
    assert {code for code, _ in refused(whole.folder)} == {"PR112"}


def test_a_wrong_entry_is_pointed_at(whole):
    whole.states(WHOLE.replace("seam.mod", "sem.mod"))
    with pytest.raises(Refused) as caught:
        project_of(whole.folder)
    (finding,) = caught.value.findings
    assert finding.excerpt is not None and finding.column is not None
    assert finding.excerpt[finding.column - 1 :].startswith('"hand/sem.mod"')


def test_all_that_is_wrong_is_said_at_once(whole):
    whole.states(WHOLE.replace("entry", "entri").replace("load = true", "laod = true"))
    lines = [line_of(whole, "entri"), line_of(whole, "laod")]
    assert refused(whole.folder) == [("CT302", lines[0]), ("CT302", lines[1])]


def test_no_line_with_a_password_is_shown(whole):
    whole.states(WHOLE.replace("load = true", 'password = "hunter2"'))
    with pytest.raises(Refused) as caught:
        project_of(whole.folder)
    assert "hunter2" not in str([*caught.value.findings])


def test_where_no_project_is(home):
    assert refused(home.folder) == [("PR101", None)]
    home.states("")
    with pytest.raises(Refused, match="names no targets"):
        targets_of(home.folder)


def test_tables_that_are_none(home):
    home.put("assistant.toml", 'programs = 3\ntargets = "cell1"\n')
    assert refused(home.folder) == [("PR102", 1), ("PR102", 2)]

"""What a build makes, what it leaves alone, and that nothing is half there."""

import json
import shutil

import pytest

from assistant import compile
from assistant.base.diagnostics import Refused
from assistant.project import State, build, project_of, targets_of
from tests.project.conftest import Home, module, pseudo

TWO = """
[programs.waiting]
source = "waiting.pseudo"

[targets.cell1]
programs = ["waiting", "hand/seam.mod"]

[targets.cell2]
programs = ["waiting"]
"""
BUILT, UNCHANGED, FAILED = State.BUILT, State.UNCHANGED, State.FAILED


@pytest.fixture
def two(home: Home) -> Home:
    home.put("waiting.pseudo", pseudo())
    home.put("hand/seam.mod", module("seam"))
    home.states(TWO)
    return home


def states(*names: str, **options) -> list[State]:
    options = {"jobs": 1, **options}
    return [one.state for one in build(project_of(), names, **options).programs]


def codes(**options) -> list[str]:
    return [finding.code for finding in build(project_of(), jobs=1, **options).findings]


def test_each_target_gets_its_language_and_files_as_they_are(two):
    done = build(project_of(), jobs=1)
    assert (done.ok, done.status) == (True, 0)
    assert two.built("cell1") == {
        **compile("waiting.pseudo", language="rapid", robot="irb1200-7-0.7").files,
        "seam.mod": module("seam").encode(),
    }
    cr = compile("waiting.pseudo", language="melfa-basic-4", robot="rv-2aj").files
    assert two.built("cell2") == cr


def test_only_what_has_changed_is_built_again(two):
    assert states() == [BUILT, BUILT, BUILT]
    assert states() == [UNCHANGED] * 3
    two.put("hand/seam.mod", module("seam", "more"))
    assert states() == [UNCHANGED, BUILT, UNCHANGED]
    two.states(TWO.replace('seam.mod"]', 'seam.mod"]\nload = true'))  # nothing that is built
    assert states() == [UNCHANGED] * 3
    two.states(TWO.replace('pseudo"', 'pseudo"\nentry = "main"', 1))
    assert states() == [BUILT, UNCHANGED, BUILT]
    assert states("seam.mod"[:0] or "cell2", anew=True) == [BUILT]


def test_a_process_file_that_appears_is_seen(home):
    home.put(
        "taught.toml",
        '[[targets]]\nname = "a"\nposition = [400, 0, 400]\nquaternion = [0, 0, 1, 0]\n',
    )
    home.states('[programs.a]\nsource = "taught.toml"\n[targets.cell1]\nprograms = ["a"]\n')
    assert (states(), states()) == ([BUILT], [UNCHANGED])
    home.put("taught.process.toml", "[motion]\nspeed = 77\n")
    assert (states(), states()) == ([BUILT], [UNCHANGED])


def test_what_touches_something_in_its_cell_is_not_built(home):
    """Files that the cell file names are seen to change as well."""
    home.put(
        "goes.pseudo",
        "program goes\ntarget a [450, 0, 450] [0, 0, 1, 0]\ntarget b [450, 200, 450] [0, 0, 1, 0]\n"
        "procedure main\nmove joint a speed 100 mm/s blend fine\n"
        "move linear b speed 100 mm/s blend fine\nend\n",
    )
    cell = '[robots.arm]\nrobot = "irb1200-7-0.7"\n[bodies.post]\nmesh = "post.obj"\nunit = "mm"\n'
    home.put("cell/cell.toml", cell)
    corners = "v {0} 90 0\nv {1} 90 0\nv {0} 110 0\nv {0} 100 900\n"
    faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    home.put("cell/post.obj", corners.format(1400, 1420) + faces)
    program = '[programs.a]\nsource = "goes.pseudo"\ncell = "cell/cell.toml"\n'
    home.states(program + '[targets.cell1]\nprograms = ["a"]\n')
    assert (states(), states()) == ([BUILT], [UNCHANGED])
    home.put("cell/post.obj", corners.format(440, 460) + faces)
    assert states() == [FAILED]
    assert "CK421" in codes()
    home.put("cell/post.obj", corners.format(1500, 1520) + faces)
    assert states() == [BUILT]


def test_a_report_that_appears_beside_the_sources_changes_none(home):
    """`robot-assistant plan --format markdown > plan.md` makes it before it looks at them."""
    home.put("seam.mod", module("seam"))
    home.states('[targets.cell1]\nprograms = ["seam.mod"]\n')
    assert states() == [BUILT]
    for name in ("plan.md", "report.xml"):
        home.put(name, "")
    assert states() == [UNCHANGED]
    home.put("other.mod", module("other"))
    assert states() == [BUILT], "which it might call"


def test_a_file_that_a_program_calls_goes_along_and_is_seen(two):
    listed = (
        '<?xml version="1.0"?><Program><Module>one.mod</Module><Module>two.mod</Module></Program>'
    )
    two.put("hand/all.pgf", listed)
    two.put("hand/one.mod", module("one"))
    two.put("hand/two.mod", module("two"))
    two.states('[targets.cell1]\nprograms = ["hand/all.pgf"]\n')
    assert (states(), states()) == ([BUILT], [UNCHANGED])
    assert sorted(two.built()) == ["all.pgf", "one.mod", "two.mod"]
    two.put("hand/two.mod", module("two", "new"))
    assert states() == [BUILT]
    assert two.built()["two.mod"] == module("two", "new").encode()
    (target,) = targets_of()
    assert [file.name for file in target.files()] == ["all.pgf", "one.mod", "two.mod"]
    came = {file.name: source for file, source in target.sources().items()}
    assert came["two.mod"] == two.folder / "hand/two.mod"


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_it_is_the_same_bytes_elsewhere_and_at_once(jobs, two, tmp_path_factory, monkeypatch):
    build(project_of(), jobs=1)
    copy = tmp_path_factory.mktemp("other") / "place"
    shutil.copytree(two.folder, copy, ignore=shutil.ignore_patterns("build", ".robot-assistant"))
    (copy / "drawings").mkdir()
    monkeypatch.chdir(copy / "drawings")
    done = build(project_of(), jobs=jobs)
    assert done.ok, done.findings
    assert Home(copy).built("cell1") == two.built("cell1")
    assert Home(copy).built("cell2") == two.built("cell2")
    kept = ".robot-assistant/build.json"
    assert (copy / kept).read_bytes() == (two.folder / kept).read_bytes()


def test_one_that_fails_keeps_no_other_back(two):
    assert states() == [BUILT] * 3
    before = two.built("cell1")
    two.put("waiting.pseudo", "program waiting\n\nprocedure main\n  wiat 0.5 s\nend\n")
    two.put("hand/seam.mod", module("seam", "more"))
    done = build(project_of(), jobs=1)
    assert [one.state for one in done.programs] == [FAILED, BUILT, FAILED]
    assert (done.ok, done.status) == (False, 1)
    assert {finding.path for finding in done.findings} == {"waiting.pseudo"}
    assert two.built("cell1") == {**before, "seam.mod": module("seam", "more").encode()}
    with pytest.raises(Refused, match="the last build of it failed"):
        targets_of()[1].files()
    assert states() == [FAILED, UNCHANGED, FAILED]  # tried again
    two.put("waiting.pseudo", pseudo())
    assert states() == [BUILT, UNCHANGED, BUILT]


def test_a_module_with_an_error_is_not_taken(two):
    two.put("hand/seam.mod", "MODULE seam\n  PROC main(\nENDMODULE\n")
    assert states() == [BUILT, FAILED, BUILT]
    assert "seam.mod" not in two.built("cell1")


def test_two_programs_of_one_file_name(two):
    two.put("more/Seam.mod", module("other"))
    two.states(TWO.replace('"hand/seam.mod"', '"hand/seam.mod", "more/Seam.mod"'))
    assert "PR201" in codes()
    assert two.built("cell1")["seam.mod"] == module("seam").encode()


def test_what_no_target_wants_any_more_goes_away(two):
    build(project_of(), jobs=1)
    two.put("build/cell1/mine.txt", "kept")
    two.states(TWO.replace(', "hand/seam.mod"', ""))
    build(project_of(), jobs=1)
    assert sorted(two.built("cell1")) == ["mine.txt", "waiting.mod"]


@pytest.mark.parametrize(
    ("harm", "reason"),
    [
        (lambda home: home.put("waiting.pseudo", pseudo(1.0)), "was changed since"),
        (lambda home: home.put("build/cell2/WAITING.prg", "1 END"), "was changed by somebody"),
        (lambda home: (home.folder / "build/cell2/WAITING.prg").unlink(), "is not there"),
        (lambda home: (home.folder / ".robot-assistant/build.json").unlink(), "never built"),
        (lambda home: home.put(".robot-assistant/build.json", "{"), "never built"),
        (lambda home: home.put(".robot-assistant/build.json", '{"format": 9}'), "never built"),
    ],
)
def test_nothing_stale_is_deployed(two, harm, reason):
    build(project_of(), jobs=1)
    second = targets_of()[1]
    assert [file.name for file in second.files()] == ["WAITING.prg"]
    harm(two)
    with pytest.raises(Refused, match=reason) as caught:
        second.files()
    assert [finding.code for finding in caught.value.findings] == ["PR202"]
    build(project_of(), jobs=1)
    assert [file.name for file in second.files()] == ["WAITING.prg"]


def test_a_name_of_a_file_in_the_record_leads_nowhere_else(two):
    build(project_of(), jobs=1)
    kept = two.folder / ".robot-assistant/build.json"
    content = json.loads(kept.read_text())
    content["built"]["cell1/waiting"]["files"] = {"../../assistant.toml": "0" * 64}
    kept.write_text(json.dumps(content))
    assert states() == [BUILT] * 3


def test_an_unknown_name_is_refused_with_the_nearest(two):
    with pytest.raises(Refused, match="there is no program or target `wating`") as caught:
        build(project_of(), ["wating"])
    assert caught.value.findings[0].cure == "write `waiting`"
    assert caught.value.exit_status == 2


def test_a_program_whose_language_nobody_says(home):
    home.put("waiting.pseudo", pseudo())
    home.put(
        "assistant.toml",
        '[controllers]\ncr = "melfa://192.168.0.20"\n[programs.a]\nsource = "waiting.pseudo"\n'
        '[targets.cr]\nprograms = ["a"]\n',
    )
    assert codes() == ["PR111"]


def test_a_folder_that_cannot_be_written(two):
    two.put("build", "a file")
    done = build(project_of(), jobs=1)
    assert (done.status, {one.state for one in done.programs}) == (2, {FAILED})
    assert {finding.code for finding in done.findings} == {"CO201"}


def test_one_source_is_taken_as_it_is_and_translated(home):
    source = "MODULE rest\n  PROC main()\n    WaitTime 0.5;\n  ENDPROC\nENDMODULE\n"
    home.put("rest.mod", source)
    home.states(
        '[programs.rest]\nsource = "rest.mod"\n'
        '[targets.cell1]\nprograms = ["rest"]\n[targets.cell2]\nprograms = ["rest"]\n'
    )
    assert states() == [BUILT, BUILT]
    assert home.built("cell1") == {"rest.mod": source.encode()}
    (text,) = home.built("cell2").values()
    assert b"DLY 0.5" in text.upper()
    first, second = targets_of()
    assert list(first.sources().values()) == [home.folder / "rest.mod"]
    assert list(second.sources().values()) == [home.folder / "rest.mod"]


def test_what_a_link_beside_a_program_leads_to_is_not_taken(home, tmp_path_factory):
    outside = tmp_path_factory.mktemp("outside") / "two.mod"
    outside.write_text(module("two"))
    home.put("hand/all.pgf", "<Program><Module>two.mod</Module></Program>")
    (home.folder / "hand/two.mod").symlink_to(outside)
    home.states('[targets.cell1]\nprograms = ["hand/all.pgf"]\n')
    assert codes() == ["PR205"]
    assert not (home.folder / "build").exists()

"""What `init` writes: a project that builds, checks and deploys; nothing is overwritten."""

import re
import tomllib

import pytest

from assistant import __version__, deploy
from assistant.base.diagnostics import Refused
from assistant.project import build, project_of, targets_of
from assistant.project.builds import check
from assistant.project.new_project import EXAMPLE_FILES, REPOSITORY_FILES, start_project
from tests.project.conftest import Home


def test_a_new_user_builds_checks_and_deploys(home):
    started = start_project(home.folder)
    assert started.findings == ()
    written = {file.relative_to(home.folder).as_posix() for file in started.written}
    assert written == {*EXAMPLE_FILES, *REPOSITORY_FILES, "assistant.schema.json"}
    done = build(project_of(), jobs=1)
    assert done.ok and not [f for f in done.findings if f.severity != "info"]
    checked = check(project_of())
    assert (checked.programs, checked.unreadable) == (1, False)
    assert not [f for f in checked.findings if f.severity != "info"]
    (target,) = targets_of()
    with target.opened() as controller:
        plan = deploy.plan(target.files(), controller, task=target.task, load=target.load)
        assert deploy.deploy(plan).ok


def test_nothing_is_overwritten(home):
    mine = {name: f"mine {name}" for name in (*REPOSITORY_FILES, "assistant.schema.json")}
    for name, text in mine.items():
        home.put(name, text)
    started = start_project(home.folder)
    assert {name: (home.folder / name).read_text() for name in mine} == mine
    assert [finding.code for finding in started.findings] == ["PR301"] * len(mine)
    assert len(started.written) == len(EXAMPLE_FILES)
    assert start_project(home.folder).written == ()


@pytest.mark.parametrize(
    ("name", "text"),
    [("assistant.toml", "[severity]\n"), ("pyproject.toml", "[tool.robot-assistant.severity]\n")],
)
def test_a_project_that_is_there_gets_no_example(home, name, text):
    home.put(name, text)
    written = {
        file.relative_to(home.folder).as_posix() for file in start_project(home.folder).written
    }
    assert written == {*REPOSITORY_FILES, "assistant.schema.json"}


def test_a_link_out_of_the_folder_is_not_followed(home, tmp_path_factory):
    outside = tmp_path_factory.mktemp("outside")
    (home.folder / ".github").symlink_to(outside)
    with pytest.raises(Refused, match="outside"):
        start_project(home.folder)
    assert list(outside.iterdir()) == []


def test_no_secret_stands_in_what_is_written(home):
    start_project(home.folder)
    text = "".join(
        (home.folder / name).read_text("utf-8") for name in (*REPOSITORY_FILES, *EXAMPLE_FILES)
    )
    given = re.findall(r"PASSWORD *[:=] *(.*)", text)
    assert set(given) == {"${{ secrets.ROBOT_ASSISTANT_CELL1_PASSWORD }}"}


def test_what_pipelines_run_are_commands_of_this_program(home):
    """Each command of ours in the files for CI, with options that there are."""
    from click import Context

    from assistant.cli.app import app

    start_project(home.folder)
    files = (".pre-commit-config.yaml", ".github/workflows/robot.yml", ".gitlab-ci.yml")
    text = "\n".join((home.folder / name).read_text("utf-8") for name in files)
    said = re.findall(r"^\s*-?\s*(?:- run:|entry:|-) (robot-assistant [a-z].*)$", text, re.M)
    assert len(said) >= 10
    for line in said:
        command, *options = line.partition(" >")[0].split()[1:]
        there = {name for one in app.get_command(Context(app), command).params for name in one.opts}
        assert {option for option in options if option.startswith("-")} <= there, line


def test_pipelines_take_us_from_no_index(home):
    """Where anybody could put something else by our name."""
    start_project(home.folder)
    wheel = f"./wheels/robot_assistant-{__version__}-py3-none-any.whl[virtual,rws]"
    for name in (".github/workflows/robot.yml", ".gitlab-ci.yml"):
        text = (home.folder / name).read_text("utf-8")
        assert set(re.findall(r"pip install (.*)", text)) == {'"$ROBOT_ASSISTANT"'}
        assert re.findall(r"ROBOT_ASSISTANT: (.*)", text) == [f'"{wheel}"']


def test_editors_are_told_where_the_schema_is():
    from assistant.resources import resource

    text = resource("templates", "project/assistant.toml").read_text("utf-8")
    assert text.startswith("#:schema ./assistant.schema.json\n")
    assert set(tomllib.loads(text)) == {"controllers", "programs", "targets"}


def test_a_folder_that_cannot_be_made(home):
    file = home.put("file", "")
    with pytest.raises(Refused) as caught:
        start_project(file / "inside")
    assert caught.value.exit_status == 2
    assert Home(home.folder).folder.is_dir()

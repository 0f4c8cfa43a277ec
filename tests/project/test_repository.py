"""A repository whose commits are checked, built and deployed by the files that `init` writes.

The commands are run by git's hooks as they stand in those files: nothing of them is written here.
Before a commit the hooks of pre-commit, behind it the jobs of the pipeline.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import ezdxf
import pytest
import yaml

from assistant.deploy import all_journals

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
THEIRS = "MODULE theirs\n  PROC theirs_go()\n    WaitTime 1;\n  ENDPROC\nENDMODULE\n"
INSTALLING = "python -m pip install "
"""How the steps begin that bring what these tests run already."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, with the command `robot-assistant` in the path and a home of its own."""
    tools = tmp_path / "tools"
    tools.mkdir()
    command = tools / "robot-assistant"
    command.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m assistant "$@"\n')
    command.chmod(0o755)
    for name in [name for name in os.environ if name.startswith(("ROBOT_ASSISTANT_", "GIT_"))]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PATH", f"{tools}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("HOME", str(tmp_path))
    for name in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{name}_NAME", "A. User")
        monkeypatch.setenv(f"GIT_{name}_EMAIL", "user@example.com")
    work = tmp_path / "work"
    work.mkdir()
    return work


def shell(folder, line, status=0):
    """What a line of a shell says, on both of its outputs."""
    done = subprocess.run(
        ["/bin/sh", "-c", line], cwd=folder, capture_output=True, text=True, timeout=120
    )
    said = done.stdout + done.stderr
    assert done.returncode == status, said
    assert "Traceback" not in said
    return said


def read(folder, name):
    return yaml.safe_load((folder / name).read_text())


def before_commit(folder):
    (repository,) = read(folder, ".pre-commit-config.yaml")["repos"]
    assert all(hook["language"] == "system" for hook in repository["hooks"])
    return [hook["entry"] for hook in repository["hooks"]]


def of_github(folder, job):
    steps = read(folder, ".github/workflows/robot.yml")["jobs"][job]["steps"]
    return [step["run"] for step in steps if "run" in step and "if" not in step]


def of_gitlab(folder, job):
    pipeline = read(folder, ".gitlab-ci.yml")
    return [*pipeline["default"]["before_script"], *pipeline[job]["script"]]


def pipeline(folder, kind, *jobs):
    """The lines of jobs one after another, as on a branch that is deployed."""
    lines = [line for job in jobs for line in kind(folder, job)]
    assert lines[0].startswith(INSTALLING)
    return [line for line in lines if not line.startswith(INSTALLING)]


class Repository:
    """A repository that `init` has begun, with hooks; `said` by the last run of its pipeline."""

    def __init__(self, folder, kind):
        self.folder = folder
        shell(folder, "git init -q -b main && robot-assistant init")
        self.hook("pre-commit", before_commit(folder))
        self.hook("post-commit", pipeline(folder, kind, "build", "deploy"))

    def hook(self, name, lines):
        """Its first line that fails ends it; a commit is kept from being made by that."""
        told = self.folder / ".git" / f"{name}.log"
        text = "\n".join(["#!/bin/sh -ex", f"exec > {shlex.quote(str(told))} 2>&1", *lines])
        file = self.folder / ".git" / "hooks" / name
        file.write_text(text + "\n")
        file.chmod(0o755)

    def said(self, name):
        return (self.folder / ".git" / f"{name}.log").read_text()

    def commit(self, message, *options, status=0):
        shell(
            self.folder, f"git add -A && git commit -q {' '.join(options)} -m '{message}'", status
        )

    @property
    def head(self):
        return shell(self.folder, "git rev-parse HEAD").strip()

    @property
    def home(self):
        return self.folder / ".robot-assistant" / "virtual" / "cell1" / "home"

    @property
    def memory(self):
        """Text of each module in the program memory of the controller."""
        rows = json.loads((self.home.parent / "memory.json").read_text())
        return {row["name"]: row["text"] for row in rows}

    def on_controller(self):
        """All files on its disk, and what is in its memory."""
        files = {file.name: file.read_bytes() for file in self.home.rglob("*") if file.is_file()}
        return files, self.memory

    def deployments(self):
        return all_journals(self.folder / ".robot-assistant" / "deployments")

    def put_theirs(self):
        """A module of somebody else on the controller, also in its memory."""
        (self.home / "theirs.mod").write_text(THEIRS)
        file = self.home.parent / "memory.json"
        rows = json.loads(file.read_text())
        rows.append({"name": "theirs", "file": "theirs.mod", "text": THEIRS})
        file.write_text(json.dumps(rows))

    def move_point(self, by):
        """The centre of the circle that is glued, in mm along x."""
        file = self.folder / "drawings" / "plate.dxf"
        drawing = ezdxf.readfile(file)
        (circle,) = drawing.modelspace().query('CIRCLE[layer=="GLUE"]')
        circle.dxf.center += (by, 0, 0)
        drawing.saveas(file)

    def break_a_check(self):
        """The plate is put where the robot does not reach."""
        file = self.folder / "drawings" / "plate.process.toml"
        text = file.read_text()
        changed = re.sub(r"^position = \[330,", "position = [3300,", text, flags=re.M)
        assert changed != text
        file.write_text(changed)


@pytest.mark.parametrize("kind", [of_github, of_gitlab])
def test_a_commit_leads_to_a_new_program_and_to_nothing_else(folder, kind):
    repository = Repository(folder, kind)
    repository.commit("one")
    assert "1 installed and verified" in repository.said("post-commit")
    first = (repository.home / "plate.mod").read_bytes()
    assert [(one.result, one.record.commit) for one in repository.deployments()] == [
        ("done", repository.head)
    ]
    repository.put_theirs()
    files, memory = repository.on_controller()

    repository.move_point(4.0)
    repository.commit("two")
    assert "1 installed and verified" in repository.said("post-commit")
    new_files, new_memory = repository.on_controller()
    second = new_files.pop("plate.mod")
    assert second != first == files.pop("plate.mod")
    assert second == (folder / "build" / "cell1" / "plate.mod").read_bytes()
    ours = {"robot-assistant.json", "robot-assistant.zip"}
    assert {name: new_files[name] for name in new_files.keys() - ours} == {
        name: files[name] for name in files.keys() - ours
    }
    assert new_memory.pop("plate") != memory.pop("plate") and new_memory == memory
    assert memory == {"theirs": THEIRS}
    last = repository.deployments()[-1]
    assert (last.result, last.record.commit) == ("done", repository.head)
    assert [entry.name for entry in last.entries] == ["plate.mod"]
    assert last.entries[0].before.file == first
    _only_the_circle_moved(first.decode(), second.decode(), 4.0)

    shell(folder, "robot-assistant rollback")
    assert (repository.home / "plate.mod").read_bytes() == first
    assert repository.on_controller()[1]["theirs"] == THEIRS


def _only_the_circle_moved(before, after, by):
    """Of the targets that differ, each is as far along x from what it was."""
    target = re.compile(r"robtarget .*?\[\[([-\d.]+),([-\d.]+),([-\d.]+)\]")
    old, new = (
        [tuple(map(float, found)) for found in target.findall(text)] for text in (before, after)
    )
    assert len(old) == len(new) > 0
    moved = [(one, other) for one, other in zip(old, new, strict=True) if one != other]
    assert 0 < len(moved) < len(old)
    for one, other in moved:
        assert other == pytest.approx((one[0] + by, one[1], one[2]), abs=1e-3)


@pytest.mark.parametrize("kind", [of_github, of_gitlab])
def test_a_commit_that_breaks_a_check_leaves_the_controller_alone(folder, kind):
    """It is not made; and where somebody makes it all the same, the pipeline stops before."""
    repository = Repository(folder, kind)
    repository.commit("one")
    before, head = repository.on_controller(), repository.head
    log = repository.said("post-commit")

    repository.break_a_check()
    repository.commit("two", status=1)
    assert repository.head == head and " error " in repository.said("pre-commit")
    assert repository.said("post-commit") == log, "no commit, no pipeline"
    assert repository.on_controller() == before

    repository.commit("two", "--no-verify")
    assert repository.head != head
    said = repository.said("post-commit")
    assert "robot-assistant check" in said and "robot-assistant deploy" not in said
    assert repository.on_controller() == before
    assert len(repository.deployments()) == 1

    shell(folder, "robot-assistant deploy", status=1)
    assert repository.on_controller() == before, "what is built is not what the sources say"


@pytest.mark.parametrize("kind", [of_github, of_gitlab])
def test_a_pull_request_gets_the_plan(folder, kind):
    repository = Repository(folder, kind)
    repository.commit("one")
    before = repository.on_controller()
    repository.move_point(4.0)
    for line in pipeline(folder, kind, "plan"):
        shell(folder, line)
    plan = (folder / "plan.md").read_text()
    assert re.search(r"\| `plate.mod` \| \**replace", plan) and "```diff" in plan
    assert repository.on_controller() == before


def test_the_commands_of_the_first_page(folder):
    """As a new user types them, in an empty folder, with nothing else running."""
    said = shell(folder, "robot-assistant init && robot-assistant build && robot-assistant deploy")
    assert "1 installed and verified" in said
    assert shutil.which("git") and "fatal" not in said
    assert "robot-assistant deploy" in said, "init tells what comes next"
    assert shell(folder, "robot-assistant deploy").count("already there") == 1
    assert "as deployed" in shell(folder, "robot-assistant verify")

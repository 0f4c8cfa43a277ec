"""What a checkout offers to pipelines: the image, the action of GitHub, the hooks of pre-commit.

No image is built and no runner of GitHub asked: the commands of the files are run, each in an
environment that holds nothing else.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import venv
from pathlib import Path
from typing import Any

import pytest
import yaml
from click import Context

from assistant import languages, sources
from assistant.cli.app import app
from assistant.program import pseudo

PROJECT = Path(__file__).parent.parent
HOOKS = yaml.safe_load((PROJECT / ".pre-commit-hooks.yaml").read_text("utf-8"))
ACTION = yaml.safe_load((PROJECT / "action.yml").read_text("utf-8"))
PAGE = (PROJECT / "docs" / "ci.md").read_text("utf-8")
ODD = """MODULE odd
  CONST robtarget p1:=[[400,0,300],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveL p1,v25,fine,tool0;
  ENDPROC
ENDMODULE
"""
"""A program with a warning: `v25` is declared nowhere."""


def instructions() -> list[tuple[str, str]]:
    """Words of the Dockerfile and what they are given."""
    lines = (PROJECT / "Dockerfile").read_text("utf-8").splitlines()
    told = [line.partition(" ") for line in lines if line and not line.startswith("#")]
    return [(word, given) for word, _, given in told]


def words_of(line: str) -> list[str]:
    return [word for word in shlex.split(line) if word.startswith("-")]


def test_all_commands_of_these_files_are_commands_of_this_program():
    lines = [hook["entry"] for hook in HOOKS]
    lines += [step["run"] for step in ACTION["runs"]["steps"] if "run" in step]
    for block in re.findall(r"^```\w+\n(.*?)^```", PAGE, re.M | re.S):
        lines += re.findall(r"robot-assistant (?:check|compile|explain) .*", block)
    ours = [
        line.partition("robot-assistant ")[2].partition(" >")[0].partition("  #")[0]
        for line in lines
        if line.startswith("robot-assistant ")
    ]
    assert len(ours) >= 10
    for line in ours:
        command = app.get_command(Context(app), line.split()[0])
        assert set(words_of(line)) <= {name for one in command.params for name in one.opts}, line


def test_the_action_and_the_page_agree():
    given = {key: step["with"] for key, step in _uses(PAGE).items()}["./robot-assistant"]
    assert given.keys() <= ACTION["inputs"].keys()
    said = "\n".join(step.get("run", "") for step in ACTION["runs"]["steps"])
    assert "${{" not in said, "what a workflow is given is never part of a script"
    assert all("shell" in step for step in ACTION["runs"]["steps"] if "run" in step)


def _uses(page: str) -> dict[str, dict[str, Any]]:
    blocks = re.findall(r"^```yaml\n(.*?)^```", page, re.M | re.S)
    read = [yaml.safe_load(block) for block in blocks]
    steps = [step for block in read if isinstance(block, list) for step in block]
    return {step["uses"]: step for step in steps if "uses" in step}


def test_hooks_look_at_all_files_that_are_read():
    spoken = {s for name in languages.names() for s in languages.get(name).suffixes}
    by_id = {hook["id"]: re.compile(hook["files"]) for hook in HOOKS}
    for suffix in {*spoken, *sources.READERS, pseudo.SUFFIX}:
        for name in (f"a{suffix}", f"folder/B{suffix.upper()}"):
            assert by_id["robot-assistant-check"].search(name), name
    assert not by_id["robot-assistant-check"].search("a.modem")
    assert not by_id["robot-assistant-fmt"].search("plate.dxf")
    named = re.findall(r"^\| `(robot-assistant-\w+)` \|", PAGE, re.M)
    assert named == list(by_id)


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of this checkout that git knows, in a folder of their own."""
    folder = tmp_path_factory.mktemp("checkout")
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=PROJECT,
        capture_output=True,
        check=True,
    )
    for name in filter(None, listed.stdout.decode().split("\0")):
        if name.split("/")[0] not in ("tests", "benchmarks", "docs") and (PROJECT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(PROJECT / name, folder / name)
    return folder


class Empty:
    """An environment that holds nothing but pip, with a folder of programs to work in."""

    def __init__(self, folder: Path) -> None:
        venv.create(folder / "env", with_pip=True)
        self.work = folder / "work"
        self.work.mkdir()
        (self.work / "odd.mod").write_text(ODD, encoding="utf-8")
        self.scripts = folder / "env" / ("Scripts" if sys.platform == "win32" else "bin")

    def run(self, command: str | list[str], **given: str) -> subprocess.CompletedProcess[str]:
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL_ENV"))}
        path = f"{self.scripts}{os.pathsep}{kept['PATH']}"
        words = ["bash", "-ec", command] if isinstance(command, str) else command
        return subprocess.run(
            words if isinstance(command, str) else [str(self.scripts / words[0]), *words[1:]],
            cwd=self.work,
            env={**kept, "PATH": path, **given},
            capture_output=True,
            text=True,
        )


@pytest.fixture
def empty(tmp_path: Path) -> Empty:
    return Empty(tmp_path)


@pytest.mark.slow
def test_what_the_dockerfile_does_works_in_an_empty_environment(copy, empty):
    told = dict(instructions())
    assert told["FROM"].startswith("python:3.12")
    assert told["COPY"] == ". /opt/checkout"
    done = empty.run(told["RUN"].replace("/opt/checkout", str(copy)))
    assert done.returncode == 0, done.stderr
    entry, command = (yaml.safe_load(told[word]) for word in ("ENTRYPOINT", "CMD"))
    assert empty.run([*entry, *command]).returncode == 2, "no project is here"
    done = empty.run([*entry, "check", "odd.mod"])
    assert done.returncode == 1 and "RA204" in done.stderr
    done = empty.run([*entry, "check", "odd.mod", "--fail-on", "error"])
    assert done.returncode == 0 and "RA204" in done.stderr
    assert empty.run([*entry, "init", "."]).returncode == 0
    assert empty.run([*entry, *command]).returncode == 0


@pytest.mark.slow
def test_what_the_action_does_works_in_an_empty_environment(copy, empty):
    steps = [step for step in ACTION["runs"]["steps"] if "run" in step]
    inputs = {f"inputs.{key}": one["default"] for key, one in ACTION["inputs"].items()}

    def as_github(sources: str, fail_on: str) -> list[subprocess.CompletedProcess[str]]:
        values = {**inputs, "inputs.sources": sources, "inputs.fail-on": fail_on}
        values["github.action_path"] = str(copy)
        ran = []
        for step in steps:
            given = {
                key: re.sub(r"\$\{\{ ([\w.-]+) \}\}", lambda found: values[found[1]], text)
                for key, text in step["env"].items()
            }
            ran.append(empty.run(step["run"], **given))
        return ran

    installed, checked = as_github("odd.mod", inputs["inputs.fail-on"])
    assert installed.returncode == 0, installed.stderr
    assert checked.returncode == 1 and checked.stdout.startswith("::warning file=odd.mod,line=4")
    assert as_github("odd.mod", "error")[-1].returncode == 0
    assert as_github("$(touch owned) ;touch owned", "error")[-1].returncode == 2
    assert not (empty.work / "owned").exists()


@pytest.mark.slow
def test_what_a_hook_installs_has_its_entries(copy, empty):
    """pre-commit installs a repository by `pip install .` and calls the entry with names."""
    done = empty.run(f"cd {shlex.quote(str(copy))} && python -m pip install .")
    assert done.returncode == 0, done.stderr
    by_id = {hook["id"]: shlex.split(hook["entry"]) for hook in HOOKS}
    assert empty.run([*by_id["robot-assistant-fmt"], "--check", "odd.mod"]).returncode == 1
    assert empty.run([*by_id["robot-assistant-fmt"], "odd.mod"]).returncode == 0
    assert empty.run([*by_id["robot-assistant-fmt"], "--check", "odd.mod"]).returncode == 0
    assert empty.run([*by_id["robot-assistant-check"], "."]).returncode == 1
    assert empty.run(["robot-assistant", "init", "."]).returncode == 0
    (empty.work / "odd.mod").unlink()
    assert empty.run(by_id["robot-assistant-check"]).returncode == 0
    assert empty.run(by_id["robot-assistant-build"]).returncode == 0

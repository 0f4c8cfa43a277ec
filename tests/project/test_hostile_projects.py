"""Repositories of strangers: names, paths and links in them lead nowhere out of their folder."""

import json

import pytest

from assistant.base.diagnostics import Refused
from assistant.cli import main
from assistant.project import build, project_of, targets_of
from assistant.project.build_jobs import digest_of
from tests.project.conftest import Home, module

OUTSIDE = (
    "../secret.mod", "hand/../../secret.mod", "/etc/hostname.mod", "C:\\secret.mod",
    "..\\secret.mod", "hand/link.mod", "hand\x00.mod", "linked/secret.mod",
)  # fmt: skip
PROJECT = """
[controllers.cell1]
address = "virtual:cr"
[controllers.cell2]
address = "virtual:irc5"
[targets.cell2]
programs = ["seam.mod"]
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project with a program of its own; beside its folder a file that is nobody's business."""
    folder = tmp_path / "mine"
    folder.mkdir()
    monkeypatch.chdir(folder)
    home = Home(folder)
    home.put("assistant.toml", PROJECT)
    home.put("seam.mod", module("seam"))
    (home.folder / "hand").mkdir()
    (home.folder.parent / "secret.mod").write_text(module("secret"))
    return home


def everything(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@pytest.mark.parametrize("path", OUTSIDE)
@pytest.mark.parametrize("key", ["programs", "source"])
def test_no_file_outside_is_read(project, path, key):
    (project.folder / "hand" / "link.mod").symlink_to("../../secret.mod")
    (project.folder / "linked").symlink_to("..")
    text = json.dumps(path)
    lines = {
        "programs": PROJECT.replace('"seam.mod"', text),
        "source": PROJECT.replace("seam.mod", "mine") + f"[programs.mine]\nsource = {text}\n",
    }
    project.put("assistant.toml", lines[key])
    with pytest.raises(Refused) as refused:
        project_of()
    assert set(codes(refused)) <= {"PR104", "PR105"}


@pytest.mark.parametrize("name", ["../x", "..", "a/b", "a\\\\b", "a b", "\\u001b[31m", "con.x", ""])
@pytest.mark.parametrize("kind", ["targets", "controllers", "programs"])
def test_no_name_is_a_path(project, name, kind):
    """Folders are called by names of targets and controllers."""
    extra = {"targets": 'programs = ["seam.mod"]\ncontroller = "cell1"', "programs": 'source = "x"'}
    line = extra.get(kind, 'address = "virtual:cr"')
    project.put("assistant.toml", f'{PROJECT}\n[{kind}."{name}"]\n{line}\n')
    before = everything(project.folder.parent)
    with pytest.raises(Refused):
        build(project_of())
    assert everything(project.folder.parent) == before


@pytest.mark.parametrize(
    "link", ["build", "build/cell2", ".robot-assistant", ".robot-assistant/virtual",
             ".robot-assistant/virtual/cell2/home", ".robot-assistant/deployments"]
)  # fmt: skip
def test_nothing_is_written_through_a_link(project, link, capsys):
    elsewhere = project.folder.parent / "elsewhere"
    elsewhere.mkdir()
    (project.folder / link).parent.mkdir(parents=True, exist_ok=True)
    (project.folder / link).symlink_to(elsewhere)
    for command in ("build", "deploy"):
        with pytest.raises(SystemExit) as ended:
            main([command])
        assert ended.value.code == 2
        told = capsys.readouterr().err
        assert f"`{link}` is" in told and ("PR104" in told or "PR112" in told)
    assert list(elsewhere.iterdir()) == []


def test_no_file_is_written_or_deleted_through_one(project):
    """Of files, too: a lock, a program on a virtual disk, a list of what was built."""
    victim = project.folder.parent / "secret.mod"
    before = victim.read_bytes()
    for name in ("virtual/cell2/lock", "virtual/cell2/home/~seam.mod", "build.json"):
        link = project.folder / ".robot-assistant" / name
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(victim)
        with pytest.raises(Refused) as refused:
            targets_of()
        assert codes(refused) == ["PR112"]
        link.unlink()
    assert victim.read_bytes() == before


@pytest.mark.parametrize("key", ["../x", "..", "cell2/../..", "/x"])
def test_a_list_of_what_was_built_deletes_nothing_else(project, key):
    """What no target wants any more is taken away, by what the list says of it."""
    digest = digest_of((project.folder / "assistant.toml").read_bytes())
    files = {"assistant.toml": digest, "seam.mod": digest_of(module("seam").encode())}
    row = {"wanted": "", "inputs": {}, "files": files}
    listed = {"format": 1, "built": {key: row}}
    project.put(".robot-assistant/build.json", json.dumps(listed))
    (project.folder / "build").mkdir()
    assert build(project_of()).ok
    assert (project.folder / "assistant.toml").exists()
    assert (project.folder / "seam.mod").exists()

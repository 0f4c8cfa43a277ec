"""The commit of a project, whose repository may name programs for git to start."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from assistant.deploy.record import new_record
from assistant.deploy.repository import commit_of, is_committed

pytestmark = pytest.mark.skipif(shutil.which("git") is None, reason="there is no git")
WHO = ("-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "protocol.file.allow=always")
NAME = "seam.mod"


def git(folder: Path, *words: object) -> str:
    done = subprocess.run(
        ["git", *WHO, *map(str, words)], cwd=folder, check=True, capture_output=True, text=True
    )
    return done.stdout.strip()


def started(folder: Path) -> Path:
    """A repository of one program."""
    folder.mkdir()
    git(folder, "init", "-q")
    (folder / NAME).write_text("MODULE seam\nENDMODULE\n")
    return committed(folder)


def committed(folder: Path) -> Path:
    git(folder, "add", ".")
    git(folder, "commit", "-qm", "one")
    return folder


def aged(file: Path) -> None:
    """What git cannot know to be unchanged without looking at it."""
    os.utime(file, (1_600_000_000, 1_600_000_000))


def test_changes_are_told_those_of_submodules_too(tmp_path):
    inner, project = started(tmp_path / "inner"), started(tmp_path / "project")
    assert commit_of(project) == git(project, "rev-parse", "HEAD")
    git(project, "submodule", "--quiet", "add", inner, "deeper/inner")
    assert commit_of(project).endswith("-dirty")
    committed(project)
    head = git(project, "rev-parse", "HEAD")
    assert commit_of(project) == commit_of(project / "deeper") == head
    (project / "deeper" / "inner" / NAME).write_text("")
    assert commit_of(project) == commit_of(project / "deeper") == head + "-dirty"
    assert commit_of(tmp_path) == ""


def test_a_record_has_the_commit_of_the_working_folder(tmp_path, monkeypatch):
    assert new_record("ftp://a", None).commit == ""
    project = started(tmp_path / "project")
    monkeypatch.chdir(project)
    assert new_record("ftp://a", None).commit == git(project, "rev-parse", "HEAD")


def test_a_file_is_committed_changed_ignored_or_in_no_repository(tmp_path):
    project = started(tmp_path / "project")
    (project / ".gitignore").write_text("out.mod\n")
    (project / "out.mod").write_text("")
    odd = project / ":(top)new.mod"
    odd.write_text("")
    assert is_committed(project / NAME) is True
    assert is_committed(odd) is False
    assert is_committed(project / "out.mod") is None
    (project / NAME).write_text("")
    assert is_committed(project / NAME) is False
    (tmp_path / NAME).write_text("")
    assert is_committed(tmp_path / NAME) is None


def by_filter(folder: Path, program: Path) -> Path:
    (folder / ".gitattributes").write_text("* filter=odd\n")
    git(folder, "config", "filter.odd.clean", program)
    return folder


def by_process(folder: Path, program: Path) -> Path:
    by_filter(folder, program)
    git(folder, "config", "filter.odd.process", program)
    git(folder, "config", "filter.odd.required", "true")
    return folder


def by_filter_of_a_file_elsewhere(folder: Path, program: Path) -> Path:
    by_filter(folder, program)
    other = folder.parent / "other"
    git(folder, "config", "--file", other, "filter.odd.clean", program)
    git(folder, "config", "--remove-section", "filter.odd")
    git(folder, "config", "include.path", other)
    return folder


def by_filter_of_odd_name(folder: Path, program: Path) -> Path:
    (folder / ".gitattributes").write_text("* filter=o=dd\n")
    git(folder, "config", "filter.o=dd.clean", program)
    return folder


def by_hook(folder: Path, program: Path) -> Path:
    (folder / ".git" / "hooks").mkdir(exist_ok=True)
    shutil.copy(program, folder / ".git" / "hooks" / "post-index-change")
    return folder


def by_watcher(folder: Path, program: Path) -> Path:
    git(folder, "config", "core.fsmonitor", program)
    return folder


def by_fetching(folder: Path, program: Path) -> Path:
    tree = git(folder, "rev-parse", "HEAD^{tree}")
    for key, value in (
        ("core.repositoryformatversion", 1),
        ("extensions.partialClone", "far"),
        ("remote.far.promisor", "true"),
        ("remote.far.url", "ssh://nowhere/away"),
        ("core.sshCommand", program),
    ):
        git(folder, "config", key, value)
    (folder / ".git" / "objects" / tree[:2] / tree[2:]).unlink()
    return folder


def in_submodule(folder: Path, program: Path) -> Path:
    inner = started(folder.parent / "inner")
    git(folder, "submodule", "--quiet", "add", inner, "inner")
    by_filter(committed(folder) / "inner", program)
    aged(folder / "inner" / NAME)
    return folder


def as_bare_repository(folder: Path, program: Path) -> Path:
    """A folder that any clone can bring."""
    inner = folder / "inner"
    shutil.copytree(folder / ".git", inner)
    (inner / NAME).write_text("MODULE seam\nENDMODULE\n")
    git(folder, "config", "--file", inner / "config", "core.bare", "false")
    git(folder, "config", "--file", inner / "config", "core.worktree", inner)
    git(folder, "config", "--file", inner / "config", "core.fsmonitor", program)
    return inner


WAYS = [
    *(by_filter, by_process, by_filter_of_a_file_elsewhere, by_filter_of_odd_name, by_hook),
    *(by_watcher, by_fetching, in_submodule, as_bare_repository),
]


@pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")
@pytest.mark.parametrize("way", WAYS, ids=lambda way: way.__name__)
def test_no_program_of_a_repository_is_started(tmp_path, way):
    program, ran = tmp_path / "program", tmp_path / "ran"
    program.write_text(f"#!/bin/sh\ntouch '{ran}'\nexit 1\n")
    program.chmod(0o755)
    folder = way(started(tmp_path / "project"), program)
    ran.unlink(missing_ok=True)
    aged(folder / NAME)
    commit_of(folder)
    aged(folder / NAME)
    is_committed(folder / NAME)
    assert not ran.exists()
    # What it was kept from does start it.
    aged(folder / NAME)
    (folder / NAME).touch()
    plain = ["git", "status", "--porcelain"]
    subprocess.run(plain, cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, timeout=20)
    assert ran.exists()

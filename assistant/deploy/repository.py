"""Git queries on the repository around a folder, without starting programs that it names.

A repository's configuration, which a clone does not contain but an archive or a shared folder does,
may name programs: git-config(1) `core.fsmonitor`, `filter.<driver>.clean`, githooks(5)
`post-index-change`, `remote.<name>.promisor` with `core.sshCommand`. Any folder of a clone may look
like a bare repository with such a configuration.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path as FilePath
from typing import Final

from assistant.base.worker_processes import without_passwords

_OPTIONS: Final = (
    "--literal-pathspecs",
    *("-c", "core.fsmonitor=false"),
    *("-c", f"core.hooksPath={os.devnull}"),
    *("-c", "safe.bareRepository=explicit"),
)
_ALONE: Final = {
    "GIT_ALLOW_PROTOCOL": "none",  # what is missing is not fetched
    "GIT_NO_LAZY_FETCH": "1",
    "GIT_OPTIONAL_LOCKS": "0",
    "GIT_TERMINAL_PROMPT": "0",
}
_OWN: Final = ("system", "global", "command")
"""Scopes of configuration that belong to the user."""
_FILTER: Final = re.compile(r"filter\.([\w. /-]+)\.[a-z]+", re.ASCII | re.IGNORECASE)
TIMEOUT: Final = 10
"""Seconds for each question."""
_DEEPEST: Final = 8
"""Repositories in each other."""


def commit_of(folder: FilePath) -> str:
    """Return the commit of the repository around a folder, `-dirty` with changes, "" without
    one.
    """
    # --always: the commit itself where no tag is near; --exclude keeps tags out of the text.
    commit = _told(folder, "describe", "--always", "--abbrev=40", "--exclude=*")
    changed = _has_changes(folder) if commit else None
    return "" if commit is None or changed is None else commit.strip() + "-dirty" * changed


def is_committed(path: FilePath) -> bool | None:
    """True if a repository has the file in its present form; None outside of one, or without
    git.
    """
    # --ignored: a file that git ignores is in no repository, although status has no other row.
    said = _compared(path.absolute().parent, "--ignored", "--", path.name)
    return None if said is None or said.startswith("!!") else not said.strip()


def _has_changes(folder: FilePath, depth: int = 0) -> bool | None:
    """True if files of the repository differ from its commit, including those of submodules."""
    said = _compared(folder, "--untracked-files=no")
    top = _told(folder, "rev-parse", "--show-toplevel")
    if said is None or top is None:
        return None
    if said:
        return True
    place = FilePath(top.rstrip("\n"))
    rows = (_told(place, "ls-files", "--stage", "-z") or "").split("\0")
    # Mode 160000: a submodule.
    inner = [place / row.partition("\t")[2] for row in rows if row.startswith("160000 ")]
    there = [one for one in inner if (one / ".git").exists()]
    if there and depth == _DEEPEST:
        return None
    # Each with its own filters switched off: `status` of the outer one would run them.
    each = [_has_changes(one, depth + 1) for one in there]
    return None if None in each else True in each


def _compared(folder: FilePath, *words: str) -> str | None:
    """The rows of `git status`, with the user's filters and none of the repository's own."""
    listed = _told(folder, "config", "--list", "--show-scope", "--null", "--name-only")
    if listed is None:  # git before 2.26 cannot tell whose a filter is
        return None
    fields = listed.split("\0")
    without: list[str] = []
    for scope, key in zip(fields[::2], fields[1::2], strict=False):
        if scope not in _OWN and key.startswith("filter."):
            found = _FILTER.fullmatch(key)
            if found is None:
                return None  # a name by which it cannot be switched off
            for kind, value in (("clean", ""), ("process", ""), ("required", "false")):
                without += ["-c", f"filter.{found[1]}.{kind}={value}"]
    status = ("status", "--porcelain", "--ignore-submodules=dirty")
    return _told(folder, *without, *status, *words)


def _told(folder: FilePath, *words: str) -> str | None:
    """Standard output; None where there is no git, no repository, or no answer in time."""
    git = shutil.which("git")
    if git is None or not FilePath(git).is_absolute():  # one that lies in the working folder
        return None
    # GIT_DIR and the like would lead to another repository; the user's GIT_CONFIG… are kept.
    theirs = {
        name: value
        for name, value in without_passwords().items()
        if not name.startswith("GIT_") or name.startswith("GIT_CONFIG")
    }
    try:
        done = subprocess.run(  # noqa: S603
            [git, *_OPTIONS, *words],
            cwd=folder,
            env={**theirs, **_ALONE},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="surrogateescape",
            timeout=TIMEOUT,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None

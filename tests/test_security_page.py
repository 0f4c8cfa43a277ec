"""The page about security says of every command what it may touch."""

from __future__ import annotations

import re
from pathlib import Path

from click import Context

from assistant.cli.app import app

PAGE = (Path(__file__).parent.parent / "docs" / "security.md").read_text("utf-8")
ROW = re.compile(r"^\| `([a-z0-9 ]+)` \| (.*) \| (.*) \| (yes|no) \|$", re.M)
TALKS = {"deploy", "plan", "verify", "rollback", "gateway", "answer", "view", "studio"}
TALKS |= {"explore wander", "explore manual", "explore running"}
"""Commands that reach controllers without being given one as an argument, or a line of one."""

ASKS_ON_ITS_PAGE = {"studio"}
"""It is not answered in advance."""


def commands(group, path=()):
    """Names of all commands, with what options and arguments they take."""
    for name in group.list_commands(Context(group)):
        one = group.get_command(Context(group), name)
        inner = getattr(one, "commands", None)
        if inner is None or one.invoke_without_command:
            yield " ".join((*path, name)), {word for given in one.params for word in given.opts}
        if inner is not None:
            yield from commands(one, (*path, name))


def rows():
    return {name: (here, there, asks == "yes") for name, here, there, asks in ROW.findall(PAGE)}


def test_every_command_is_in_the_table():
    known = dict(commands(app))
    assert len(known) > 40
    assert set(rows()) == set(known)
    assert len(ROW.findall(PAGE)) == len(known)


def test_those_ask_that_can_be_answered_in_advance():
    known = dict(commands(app))
    assert {n for n, (_, _, asks) in rows().items() if asks} - ASKS_ON_ITS_PAGE == {
        name
        for name, options in known.items()
        # The questions of `init` are about values of new files: nothing is confirmed.
        if "--yes" in options and name != "init"
    }
    for _, there, asks in rows().values():
        assert ("*" in there) == asks


def test_what_is_written_are_options_that_there_are():
    known = dict(commands(app))
    for name, (here, there, _) in rows().items():
        named = set(re.findall(r"`(--?[a-z-]+)`", here + there))
        assert named <= known[name], name


def test_those_reach_a_controller_that_are_given_one():
    known = dict(commands(app))
    quiet = ("nothing", "is one", "virtual ones of its own")
    reaching = {name for name, (_, there, _) in rows().items() if there not in quiet}
    assert reaching == TALKS | {n for n, options in known.items() if "cell" in options}

"""Controllers that a project names: `[controllers]` of assistant.toml or pyproject.toml.

[controllers]
cell1 = "melfa://192.168.0.20"

[controllers.cell2]
address = "rws://192.168.125.1"
user = "engineer"               # never a password
robot = "irb1200-7-0.7"         # or a robot file, from the project's folder
certificate = "cell2.pem"       # to trust it by, from the project's folder
timeout = 10                    # seconds to wait for an answer
serial = "1200-501234"          # number that it must report

[controllers.trial]
address = "virtual:irc5"        # or virtual:cr: a virtual controller that deployments start
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule
from assistant.controllers import rules
from assistant.controllers.address import (
    VIRTUAL,
    VIRTUALLY,
    Address,
    holds_password,
    parse,
    password_variable,
    without_password,
)

if TYPE_CHECKING:
    from assistant.program.settings_tables import Table

NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_NO_USER: Final = re.compile("[:/=;?#]")
"""Characters that separate a user from a password, or from another word, and are in no user
name.
"""
SECRET: Final = re.compile(r"pass|pwd|secret|token|credential", re.IGNORECASE)
"""Keys that somebody may write a password behind."""
ROBOT_FILES: Final = (".toml", ".urdf")
"""Endings of the name of a robot file."""
LONGEST_TIMEOUT: Final = 3600.0


@dataclass(frozen=True, slots=True)
class Named:
    """A controller with its known settings.

    name: in the project, or the address itself if no project names it. robot: that it moves, by its
    name or its file. timeout: seconds to wait for an answer. serial: number that it must report.
    virtual: which one of `VIRTUAL` the project itself starts; its address has port 0 until it runs.
    """

    name: str
    address: Address
    robot: str | None = None
    certificate: FilePath | None = None
    timeout: float | None = None
    serial: str | None = None
    virtual: str | None = None

    @property
    def variables(self) -> str:
        """The name that its variables of the environment have, "" where no project names it."""
        return self.name if NAME.fullmatch(self.name) else ""

    @property
    def word(self) -> str:
        """Word that a user types for this controller."""
        return self.variables or self.address.host


def named(text: str, folder: FilePath | None = None) -> Named:
    """Return the controller of an address, or of a name in a folder's project (default: this one).

    Raises Refused and Unreadable, of exit status 2, if it is missing.
    """
    if NAME.fullmatch(text) is None:
        address = parse(text)
        return Named(str(address), address)
    return of_project(text, folder or FilePath.cwd())


def of_project(name: str, folder: FilePath) -> Named:
    """The controller of that name in a folder's project; raises Unreadable and Refused."""
    there = controllers_of(folder)
    if name not in there:
        known = ", ".join(f"`{one}`" for one in there) or "none"
        raise Refused(rules.UNKNOWN_NAME(place=name, name=name, known=known), exit_status=2)
    return there[name]


def controllers_of(folder: FilePath) -> dict[str, Named]:
    """The controllers of a folder's project by their names; raises Unreadable and Refused."""
    from assistant.program.project_file import CONTROLLERS, project_of
    from assistant.program.settings_tables import Page, Table

    project = project_of(folder)
    if project is None or not isinstance(project.content, Mapping):
        return {}
    content = project.content.get(CONTROLLERS, {})
    page, path = Page(project.source, project.spans), (*project.table, CONTROLLERS)
    if not isinstance(content, dict):
        page.say(rules.NO_TABLE_OF_CONTROLLERS, path, key=".".join(path))
        content = {}
    table = Table(page, path, content)
    read = _Reader(table, FilePath(project.source.path or "").absolute().parent)
    found = {name: read.entry(name) for name in content}
    read.check_variables()
    if page.findings:
        # The lines of the file are not shown: a password may stand in one.
        shown = (replace(finding, excerpt=None) for finding in page.findings)
        raise Refused(*sorted(shown, key=lambda f: f.line or 0), exit_status=2)
    return {name: one for name, one in found.items() if one is not None}


def keys() -> Mapping[str, Callable[[Any], Any]]:
    """Return the permitted keys of a controller's table, each with the reader of its value."""
    from assistant.program import settings_tables

    return {
        "address": settings_tables.text,
        "robot": settings_tables.text,
        "user": settings_tables.text,
        "certificate": settings_tables.text,
        "timeout": settings_tables.number("seconds", above=0.0, most=LONGEST_TIMEOUT),
        "serial": settings_tables.text,
    }


class _Reader:
    """Reads the entries of a table of controllers. folder: of the project's file."""

    def __init__(self, table: Table, folder: FilePath) -> None:
        self.table, self.folder, self.keys = table, folder, keys()

    def entry(self, name: str) -> Named | None:
        """Read a controller, None if its entry is wrong."""
        if NAME.fullmatch(name) is None:
            self.table.say(rules.BAD_NAME, name, name=without_password(name))
            return None
        given = self.table.content[name]
        if isinstance(given, str):
            address = self._address(given, (name,))
            return None if address is None else Named(name, address, virtual=_virtual(given))
        table = self.table.table(name)
        secrets = [key for key in table.content if SECRET.search(key)]
        for key in secrets:
            table.say(
                rules.PASSWORD_IN_FILE, key, name=name, variable=password_variable(name, "PASSWORD")
            )
        # Keys that may hold a password are reported alone, and never read.
        kept = {key: value for key, value in table.content.items() if key not in secrets}
        found = replace(table, content=kept).read(self.keys)
        if "address" not in table.content and isinstance(given, dict):
            table.say(rules.NO_ADDRESS, name=name)
        address = self._address(found["address"], (name, "address")) if "address" in found else None
        if address is None:
            return None
        # A colon or the like in a user: the text after it may be a password.
        if _NO_USER.search(found.get("user", "")):
            table.say(
                rules.PASSWORD_IN_FILE,
                "user",
                name=name,
                variable=password_variable(name, "PASSWORD"),
            )
        elif "user" in found:
            if address.user not in (None, found["user"]):
                table.say(rules.TWO_USERS, "user", name=name, one=address.user, other=found["user"])
            address = replace(address, user=found["user"])
        certificate = self.folder / found["certificate"] if "certificate" in found else None
        robot = found.get("robot")
        if robot is not None and robot.lower().endswith(ROBOT_FILES):
            robot = str(self.folder / robot)
        virtual = _virtual(found["address"])
        timeout, serial = found.get("timeout"), found.get("serial")
        return Named(name, address, robot, certificate, timeout, serial, virtual)

    def _address(self, text: str, at: tuple[str, ...]) -> Address | None:
        """The address, or None with the finding that it gives, placed at its key."""
        page, path = self.table.page, (*self.table.path, *at)
        if holds_password(text):
            page.say(
                rules.PASSWORD_IN_FILE,
                path,
                name=at[0],
                variable=password_variable(at[0], "PASSWORD"),
            )
            return None
        kind = _virtual(text)
        if kind is not None:
            return replace(VIRTUAL[kind], name=f"virtual_{at[0]}")
        try:
            return parse(text)
        except Refused as refused:
            for finding in refused.findings:
                page.say(_as_rule(finding), path)
            return None

    def check_variables(self) -> None:
        """Report names whose environment variables would be identical."""
        seen: dict[str, str] = {}
        for name in self.table.content:
            # Environment variables replace `-` by `_` and ignore case, so that names may coincide.
            other = seen.setdefault(password_variable(name, ""), name)
            if other != name:
                self.table.say(rules.SAME_VARIABLE, name, name=name, other=other)


def _virtual(text: str) -> str | None:
    """Which virtual controller an address names, None for the address of another."""
    kind = text.removeprefix(VIRTUALLY)
    return kind if kind != text and kind in VIRTUAL else None


def _as_rule(finding: Diagnostic) -> Rule:
    """A rule that says what a finding says, at another place."""

    # The message is filled in already: its braces must not be taken for fields again.
    def plain(text: str) -> str:
        return text.replace("{", "{{").replace("}", "}}")

    return Rule(finding.code, finding.severity, plain(finding.message), plain(finding.cure))

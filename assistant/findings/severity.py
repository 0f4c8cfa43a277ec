"""A project's own severities: `[severity]` of assistant.toml or pyproject.toml.

[tool.robot-assistant.severity]     # in pyproject.toml; `[severity]` in assistant.toml
RA211 = "warning"                   # one finding
RA4 = "off"                         # all whose code begins so
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.findings import rulebook
from assistant.program.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Severity,
    error,
    has_errors,
    warning,
)
from assistant.sources.project import (
    CONTROLLERS,
    DEPLOY,
    PROGRAMS,
    STYLE,
    TARGETS,
    Project,
    project_of,
)

TABLE: Final = "severity"
OFF: Final = "off"
LEVELS: Final = (OFF, *(str(s) for s in reversed(Severity)))

UNKNOWN_KEY: Final = warning("FN101", "`{key}` is no setting", "write a table `{table}`")
NO_SUCH_CODE: Final = warning(
    "FN102",
    "no finding has a code that begins with `{code}`",
    "write a code as findings show it, such as RA204, or how several begin, such as RA2",
)
NOT_LOWERED: Final = warning(
    "FN103",
    "`{code}` stays an error: it tells what cannot be read, or why nothing is written",
    "correct what it finds; errors of a language's own check of a program can be turned down",
)
NO_LEVEL: Final = error("FN104", "`{value}` is no severity", "write one of {levels}")
NO_TABLE: Final = error(
    "FN105", "`{key}` is no table", 'write lines such as RA204 = "warning" in it'
)


@dataclass(frozen=True, slots=True)
class Severities:
    """What a project wants findings to be.

    levels: severity by code or by how codes begin, None for off. findings: what is odd about
    the settings, once.
    """

    levels: Mapping[str, Severity | None] = field(default_factory=dict)
    findings: tuple[Diagnostic, ...] = ()

    def of(self, finding: Diagnostic) -> Diagnostic | None:
        """The finding as the project wants it, None if it is off."""
        beginnings = (finding.code[:n] for n in range(len(finding.code), 0, -1))
        chosen = next((b for b in beginnings if b in self.levels), None)
        if chosen is None:
            return finding
        level = self.levels[chosen]
        if is_lower(level, finding.severity) and not rulebook.is_adjustable(finding):
            return finding
        return None if level is None else replace(finding, severity=level)


AS_THEY_ARE: Final = Severities()


def is_lower(level: Severity | None, than: Severity) -> bool:
    order = list(Severity)
    return level is None or order.index(level) > order.index(than)


def severities_for(folder: FilePath) -> Severities:
    """The settings of a folder: those of the nearest file there or above it.

    Raises Unreadable or Refused, both of exit status 2, if that file is broken.
    """
    project = project_of(folder)
    if project is None:
        return AS_THEY_ARE
    found = _Page(project).severities(project.content)
    if has_errors(found.findings):
        raise Refused(*found.findings, exit_status=2)
    return found


@dataclass(slots=True)
class _Page:
    project: Project
    findings: list[Diagnostic] = field(default_factory=list)

    def severities(self, content: object) -> Severities:
        levels: dict[str, Severity | None] = {}
        if not isinstance(content, Mapping):
            self.say(NO_TABLE, (), key=".".join(self.project.table))
            return Severities(findings=tuple(self.findings))
        wanted = content.get(TABLE, {})
        table = ".".join((*self.project.table, TABLE))
        for key in content.keys() - {TABLE, *_tables()}:
            self.say(UNKNOWN_KEY, (key,), key=key, table=table)
        if not isinstance(wanted, Mapping):
            self.say(NO_TABLE, (TABLE,), key=".".join((*self.project.table, TABLE)))
            wanted = {}
        for code, value in wanted.items():
            if value not in LEVELS:
                self.say(NO_LEVEL, (TABLE, code), value=value, levels=", ".join(LEVELS))
                continue
            levels[code.upper()] = None if value == OFF else Severity(value)
        self.look_up(levels, {code.upper(): code for code in wanted})
        self.findings.sort(key=lambda f: f.line or 0)
        return Severities(levels, tuple(self.findings))

    def look_up(self, levels: Mapping[str, Severity | None], written: Mapping[str, str]) -> None:
        """Says which codes there are not, and which cannot be turned down."""
        book = rulebook.rules() if levels else {}
        for code, level in levels.items():
            at = (TABLE, written[code])
            if not code or not any(known.startswith(code) for known in book):
                self.say(NO_SUCH_CODE, at, code=written[code])
            elif (rule := book.get(code)) and is_lower(level, rule.severity):
                if not rulebook.adjustable(rule):
                    self.say(NOT_LOWERED, at, code=code)

    def say(self, rule: Rule, at: tuple[str, ...], /, **fields: object) -> None:
        self.findings.append(self.project.finding(rule, at, **fields))


def _tables() -> set[str]:
    """Other tables of a project's file: of languages, controllers, programs and deployments."""
    of_languages = {language.table for language in map(languages.get, languages.names())} - {""}
    return {*of_languages, CONTROLLERS, PROGRAMS, TARGETS, DEPLOY, STYLE}


def adjusted(findings: Iterable[Diagnostic], severities: Severities) -> list[Diagnostic]:
    """The findings as the project wants them, without those that are off."""
    wanted = (severities.of(finding) for finding in findings)
    return [finding for finding in wanted if finding is not None]

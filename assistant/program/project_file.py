"""Project file: `assistant.toml`, or the table `tool.robot-assistant` of `pyproject.toml`.

[severity]        # in assistant.toml; `[tool.robot-assistant.severity]` in pyproject.toml
RA211 = "warning"

Findings about the file never repeat a line that may contain a password.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Span, Unreadable
from assistant.base.source_text import SourceText, decode, read_bytes

PROJECT_FILES: Final[Mapping[str, tuple[str, ...]]] = {
    "assistant.toml": (),
    "pyproject.toml": ("tool", "robot-assistant"),
}
"""Name of a file → the table in it that is ours; the first that is there counts."""

CONTROLLERS: Final = "controllers"
"""Our table with the addresses of controllers."""
PROGRAMS: Final = "programs"
"""Table of the programs to compile, and their options."""
TARGETS: Final = "targets"
"""Which programs go to which controller."""
DEPLOY: Final = "deploy"
"""Table of the deployment of programs to controllers."""
STYLE: Final = "style"
"""Templates, and values for them, of the comments and frames of written programs."""
_DOUBTFUL_ADDRESS: Final = re.compile(
    r":.*[@%]|//[^/\s]*:(?![0-9]{1,5}(?:[/?#\s\"'`]|$))", re.DOTALL
)
"""Text that may be an address with a password, well-formed or not."""
_SECRET_WORD: Final = re.compile(r"\bpass|\bpwd|secret|token", re.IGNORECASE)
"""Words that a password may follow."""


class _SettingsText(SourceText):
    """The text of a project's file, of which findings repeat nothing that may be a password."""

    def finding(self, rule: Rule, span: Span, **fields: Any) -> Diagnostic:
        said = {
            key: "***" if isinstance(value, str) and _DOUBTFUL_ADDRESS.search(value) else value
            for key, value in fields.items()
        }
        return _without_secret_line(super().finding(rule, span, **said))


def _without_secret_line(finding: Diagnostic) -> Diagnostic:
    """Return the finding, without its line if that may contain a password."""
    line = finding.excerpt or ""
    doubtful = _DOUBTFUL_ADDRESS.search(line) or _SECRET_WORD.search(line)
    return replace(finding, excerpt=None) if doubtful else finding


@dataclass(frozen=True, slots=True)
class Project:
    """Our table of a project's file.

    table: where in the file it is. spans: where keys stand, by their path from the top.
    content: of the table, a mapping in a sound file.
    """

    source: SourceText
    table: tuple[str, ...]
    spans: Mapping[tuple[str, ...], Span]
    content: Any

    def finding(self, rule: Rule, at: tuple[str, ...], /, **fields: object) -> Diagnostic:
        """The rule's finding at a key of our table."""
        return self.source.finding(rule, self.spans.get((*self.table, *at), Span(0, 0)), **fields)


def project_of(folder: FilePath) -> Project | None:
    """The nearest file with a table of ours, in a folder or above it; raises Unreadable."""
    for here in (folder, *folder.parents):
        for name, table in PROJECT_FILES.items():
            file = here / name
            if file.is_file() and (found := read_project(file, table)) is not None:
                return found
    return None


def read_project(file: FilePath, table: tuple[str, ...]) -> Project | None:
    """Our table in a file, None if it is not there; raises Unreadable."""
    from assistant.base.toml_text import key_spans
    from assistant.program.settings_tables import read_toml

    read = decode(
        read_bytes(file, allow_empty=True, most=SETTINGS_FILE), str(file), ("utf-8-sig", "utf-8")
    )
    source = _SettingsText(read.text, read.path, read.encoding, read.newline)
    try:
        content: Any = read_toml(source).content
    except Unreadable as refused:
        raise Unreadable(*map(_without_secret_line, refused.findings)) from None
    for key in table:
        content = content.get(key) if isinstance(content, Mapping) else None
    if content is None:
        return None
    return Project(source, table, key_spans(source.text), content)

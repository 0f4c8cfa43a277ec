"""TOML read within a budget, and the spans of its tables, keys and values.

The standard library's reader sets itself no bound, and does not report where a key is.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import field
from typing import Any, Final

from assistant.base.budgets import READING, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span, Unreadable, error

MOST_PARTS: Final = 100
"""Parts of a dotted key. No file here needs more than 4; what `tomllib` takes for a key grows with
the square of them."""

LONG_KEY: Final = error(
    "LM007",
    "a key has more than {most} parts with dots between them",
    "write a key of fewer parts",
)

# Possessive quantifiers: a long line without such a key is scanned once.
_PART: Final = r"""(?:[A-Za-z0-9_-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_LONG_KEY_PATTERN: Final = re.compile(
    rf"(?:^|[{{,])[ \t]*+\[{{0,2}}+[ \t]*+{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_PARTS}}}",
    re.MULTILINE,
)
"""Such a key at the begin of a line, of a table's name or of an entry of an inline table."""


def parse_toml(text: str, path: str | None = None) -> dict[str, Any]:
    """Parse a TOML text.

    Raises ValueError and RecursionError as `tomllib` does, Unreadable for a key of too many parts
    and Refused for a text that takes more than its budget.
    """
    if found := _LONG_KEY_PATTERN.search(text):
        line = text.count("\n", 0, found.end()) + 1
        raise Unreadable(LONG_KEY(path=path, line=line, most=MOST_PARTS))
    with within(READING, path, len(text)):
        try:
            return tomllib.loads(text)
        except RecursionError as raised:
            deep = raised
    raise deep  # outside, as a stage has a finding of its own for it


def toml_content(text: str) -> dict[str, Any] | None:
    """Return the contents of a TOML text, None for invalid TOML; raise Refused for a text that
    takes too long to read.
    """
    try:
        return parse_toml(text)
    except (ValueError, RecursionError):
        return None


KeyPath = tuple[str, ...]

BLANK: Final = re.compile(r"[ \t]*")
_SPACE: Final = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_KEY_PART: Final = re.compile(r"""[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*'""")
# Up to two quotes may precede the three that end a multi-line text.
_QUOTED_TEXT: Final = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}|' + r"'''.*?'{3,5}|" + r"""\"(?:[^"\\\n]|\\.)*"|'[^'\n]*'""",
    re.DOTALL,
)
# A blank may separate date and time.
_BARE_VALUE: Final = re.compile(r"[^\s,\]}#]+(?: \d[^\s,\]}#]*)?")


def key_spans(text: str) -> dict[KeyPath, Span]:
    """The span of the key of every table and value, by its path from the top.

    text: TOML that `tomllib` has read. Of a table that is opened several times, or implied
    by a longer name, the first mention counts. Entries of arrays go by their number from 0.
    """
    reader = _KeyReader(text)
    reader.document()
    return reader.spans


def value_spans(text: str) -> dict[KeyPath, Span]:
    """The span of each value, by the path of its key from the top; see `key_spans`."""
    reader = _KeyReader(text)
    reader.document()
    return reader.values


@dataclass(slots=True)
class Section:
    """Lines of a table after its header, until the next header.

    path: of the table. header: start of the header's line. pairs: the paths of its keys, with the
    spans from key to value.
    """

    path: KeyPath
    header: int
    start: int
    stop: int
    pairs: list[tuple[KeyPath, Span]] = field(default_factory=list)


def sections(text: str) -> dict[KeyPath, Section]:
    """Sections by the paths of their tables: () until the first header; see `key_spans`."""
    reader = _KeyReader(text)
    reader.document()
    return {one.path: one for one in reader.sections}


class _KeyReader:
    """Reads keys and skips values; the text is known to be valid."""

    def __init__(self, text: str) -> None:
        # Entries of arrays of tables so far.
        self.text, self.at = text, 0
        self.spans: dict[KeyPath, Span] = {}
        self.values: dict[KeyPath, Span] = {}
        self.entries: dict[KeyPath, int] = {}
        self.sections = [Section((), 0, 0, len(text))]

    def document(self) -> None:
        table: KeyPath = ()
        while self._skip(_SPACE) < len(self.text):
            if self.text[self.at] == "[":
                entry = self.text.startswith("[[", self.at)
                header = self.text.rfind("\n", 0, self.at) + 1
                self.at += 1 + entry
                opening = self.at
                table = self._within_entries(self._key(()))
                if entry:
                    number = self.entries.get(table, 0)
                    self.entries[table] = number + 1
                    table = (*table, str(number))
                    self.spans[table] = Span(opening, self.at)
                self.at = self.text.index("]", self.at) + 1
                self.at += self.text.startswith("]", self.at)
                self.sections[-1].stop = header
                start = next_line(self.text, self.at)
                self.sections.append(Section(table, header, start, len(self.text)))
            else:
                start = self.at
                path = self._pair(table)
                self.sections[-1].pairs.append((path, Span(start, self.at)))

    def _within_entries(self, path: KeyPath) -> KeyPath:
        """A table's path with the number of the last entry after each array of tables."""
        found: KeyPath = ()
        for key in path[:-1]:
            found = (*found, key)
            if found in self.entries:
                found = (*found, str(self.entries[found] - 1))
        return (*found, path[-1])

    def _pair(self, table: KeyPath) -> KeyPath:
        path = self._key(table)
        self.at = self.text.index("=", self.at) + 1
        start = self._skip(_SPACE)
        self._value(path)
        self.values[path] = Span(start, self.at)
        return path

    def _key(self, table: KeyPath) -> KeyPath:
        """A dotted key; every part of it gets its place."""
        path = table
        while True:
            self._skip(BLANK)
            match = _KEY_PART.match(self.text, self.at)
            if match is None:
                raise ValueError(f"no key at character {self.at}")
            path = (*path, _unquoted_key(match[0]))
            self.spans.setdefault(path, Span(*match.span()))
            self.at = match.end()
            self._skip(BLANK)
            if not self.text.startswith(".", self.at):
                return path
            self.at += 1

    def _value(self, path: KeyPath) -> None:
        self._skip(_SPACE)
        if self.text[self.at] in "[{":
            closing = "]" if self.text[self.at] == "[" else "}"
            self.at += 1
            entry = 0
            while self.text[self._skip(_SPACE)] != closing:
                if closing == "}":
                    self._pair(path)
                else:
                    start = self.at
                    self._value((*path, str(entry)))
                    self.spans.setdefault((*path, str(entry)), Span(start, self.at))
                    entry += 1
                self._skip(_SPACE)
                self.at += self.text.startswith(",", self.at)
            self.at += 1
            return
        match = _QUOTED_TEXT.match(self.text, self.at) or _BARE_VALUE.match(self.text, self.at)
        if match is None:
            raise ValueError(f"no value at character {self.at}")
        self.at = match.end()

    def _skip(self, pattern: re.Pattern[str]) -> int:
        match = pattern.match(self.text, self.at)
        self.at = match.end() if match else self.at
        return self.at


def next_line(text: str, at: int) -> int:
    """Return the start of the line after a position, the end of the text for its last line."""
    end = text.find("\n", at)
    return len(text) if end < 0 else end + 1


def _unquoted_key(key: str) -> str:
    """A key as `tomllib` knows it, quotes and escapes resolved."""
    return next(iter(tomllib.loads(f"{key} = 0"))) if key[0] in "\"'" else key

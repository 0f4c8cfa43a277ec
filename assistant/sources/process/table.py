"""Tables of a process file, read by a table of their keys; every finding with its line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Rule, Span, error, warning
from assistant.base.source_text import SourceText
from assistant.base.toml_text import KeyPath, key_spans
from assistant.program.program import IDENTIFIER, identifier
from assistant.sources.process.values import Read, Wrong, kind_of, listed, shown

UNKNOWN_KEY = error("CT302", "there is no key `{key}` {where}", "{cure}")
BAD_VALUE = error("CT303", "`{key}` {what}", "{cure}")
NO_TABLE = error("CT304", "`{key}` is {what}, not a table", "write {cure}")
BAD_NAME = error(
    "CT305", '"{given}" is no name: letters, digits and `_`, a letter first', "write {name}"
)
SAME_NAME = error(
    "CT313", "{given} and {other} differ only in upper and lower case", "keep one of them"
)
REPAIRED = warning(
    "CT351", "`{key}` has length {length:.6f} and is brought to 1", "give more digits"
)


@dataclass(frozen=True, slots=True)
class Page:
    """The text of a process file, where its keys stand, and what was found in it."""

    source: SourceText
    spans: Mapping[KeyPath, Span]
    findings: list[Diagnostic] = field(default_factory=list)

    @staticmethod
    def of(source: SourceText) -> Page:
        return Page(source, key_spans(source.text))

    def say(self, rule: Rule, path: KeyPath, /, **fields: Any) -> None:
        """A finding at the key of that path, or at the nearest table around it."""
        known = next(path[:n] for n in range(len(path), -1, -1) if not n or path[:n] in self.spans)
        span = self.spans.get(known, Span(0, 0))
        self.findings.append(self.source.finding(rule, span, **fields))


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the file by its path."""

    page: Page
    path: KeyPath
    content: Mapping[str, Any]

    def read(self, keys: Mapping[str, Read]) -> dict[str, Any]:
        """The values of the keys that are there and right; the others become findings."""
        found: dict[str, Any] = {}
        for key, value in self.content.items():
            if key not in keys:
                self._unknown(key, keys)
                continue
            try:
                found[key] = keys[key](value)
            except Wrong as wrong:
                self.say(BAD_VALUE, key, key=key, what=wrong.what, cure=wrong.cure)
        return found

    def table(self, key: str) -> Table:
        """The table under a key; an empty one if there is none."""
        value = self.content.get(key, {})
        if not isinstance(value, dict):
            example = f"[{'.'.join((*self.path, key))}] with a line for each entry"
            self.say(NO_TABLE, key, key=shown(key), what=kind_of(value), cure=example)
            value = {}
        return Table(self.page, (*self.path, key), value)

    def named(self, *, identifiers: bool = True) -> Iterator[tuple[str, Table]]:
        """The tables in this one by name; names that are none, or come twice, are findings."""
        seen: dict[str, str] = {}
        for key in self.content:
            other = seen.setdefault(key.casefold(), key)
            if identifiers and IDENTIFIER.fullmatch(key) is None:
                self.say(BAD_NAME, key, given=shown(key), name=identifier(key))
            elif other != key:
                self.say(SAME_NAME, key, given=shown(key), other=shown(other))
            yield key, self.table(key)

    def say(self, rule: Rule, at: str | None = None, /, **fields: Any) -> None:
        """A finding at a key of the table, or at the table itself."""
        self.page.say(rule, self.path if at is None else (*self.path, at), **fields)

    def _unknown(self, key: str, keys: Mapping[str, Read]) -> None:
        where = f"in [{'.'.join(shown(p) for p in self.path)}]" if self.path else "here"
        near = nearest(key, keys)
        cure = f"write `{near}`" if near else f"use one of {listed(list(keys))}"
        self.say(UNKNOWN_KEY, key, key=shown(key), where=where, cure=cure)


def nearest(given: str, known: Iterable[str]) -> str | None:
    """The known name that is most like the given one, without case."""
    plain: Final = {name.casefold(): name for name in known}
    close = get_close_matches(given.casefold(), plain, n=1, cutoff=0.7)
    return plain[close[0]] if close else None

"""Values put into a TOML text that people write: comments, order and layout stay as they are."""

from __future__ import annotations

import copy
import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

from assistant.base import toml_text
from assistant.base.diagnostics import Refused
from assistant.base.toml_text import KeyPath, key_spans, value_spans
from assistant.project.drafting import COMMENT_COLUMN, toml_quoted
from assistant.studio import rules
from assistant.studio.answering import not_asked

BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
TRAILING_COMMENT: Final = re.compile(r"[^\S\n]*(#[^\n]*)?$")


def with_values(text: str, values: Mapping[KeyPath, Any], name: str) -> str:
    """A text in which keys have these values; None takes a key away.

    A key that stands there behind a `#`, as a choice, gets its place. Raises Refused if the text
    would say anything else than before beside that. name: of the file, for the finding.
    """
    meant = _key_position(toml_content(text), values)
    changed = None if meant is None else _changed_text(text, values)
    if changed is None or toml_content(changed) != meant:
        key = ".".join(next(iter(values), ()))
        raise Refused(rules.NOT_KEPT(path=name, key=key, name=name))
    return changed


def _changed_text(text: str, values: Mapping[KeyPath, Any]) -> str | None:
    """None if a value breaks the text."""
    for path, value in values.items():
        text = _with_one_value(text, path, value)
        if toml_content(text) is None:
            return None
    return text


def toml_value(value: Any) -> str:
    """A value as TOML has it, in one line. Raises Refused for what it has nothing for."""
    match value:
        case bool():
            return "true" if value else "false"
        case int():
            return str(value)
        case float() if math.isfinite(value):
            return json.dumps(int(value) if value.is_integer() and abs(value) < 1e15 else value)
        case str():
            return _toml_text(value)
        case Mapping():
            pairs = (f"{_toml_key(str(key))} = {toml_value(one)}" for key, one in value.items())
            return "{" + ", ".join(pairs) + "}"
        case Sequence():
            return "[" + ", ".join(map(toml_value, value)) + "]"
    raise not_asked(f"a TOML file has no {value}")


def _with_one_value(text: str, path: KeyPath, value: Any) -> str:
    there = value_spans(text).get(path)
    if there is not None:
        if value is None:
            return _without_key(text, there.start)
        return _replaced_value(text, there.start, there.end, toml_value(value))
    if value is None:
        return text
    return _with_new_key(text, path, f"{_toml_key(path[-1])} = {toml_value(value)}")


def _replaced_value(text: str, start: int, end: int, value: str) -> str:
    """The value in its place; a comment behind it stays in its column as far as there is room."""
    stop = text.find("\n", end)
    rest = text[end : stop if stop >= 0 else len(text)]
    match = TRAILING_COMMENT.match(rest)
    if match is None or match[1] is None:
        return text[:start] + value + text[end:]
    before = text[text.rfind("\n", 0, start) + 1 : start]
    line = f"{before}{value}"
    column = len(before) + (end - start) + match.start(1)
    return f"{text[: start - len(before)]}{line:{column - 1}} {match[1]}{text[end + len(rest) :]}"


def _without_key(text: str, at: int) -> str:
    start, stop = text.rfind("\n", 0, at) + 1, text.find("\n", at)
    return text[:start] + (text[stop + 1 :] if stop >= 0 else "")


def _with_new_key(text: str, path: KeyPath, line: str) -> str:
    """Where the key stands as a choice in its table; else below the last line of that."""
    start, stop = _table_region(text, path[:-1])
    if start < 0:
        header = ".".join(map(_toml_key, path[:-1]))
        gap = "" if not text else "\n" if text.endswith("\n") else "\n\n"
        return f"{text}{gap}[{header}]\n{line}\n"
    choice = re.compile(rf"^# *{re.escape(_toml_key(path[-1]))} *=[^\n]*$", re.MULTILINE)
    found = choice.search(text, start, stop)
    if found is not None:
        about = re.search(r"[^\S\n]#(?=[^#]*$)(.*)$", found[0][1:])
        said = f"{line:{COMMENT_COLUMN - 1}} #{about[1]}" if about else line
        return text[: found.start()] + said + text[found.end() :]
    body = text[start:stop]
    last = max((m.end() for m in re.finditer(r"^[^#\s\[][^\n]*\n?", body, re.MULTILINE)), default=0)
    at = start + last
    before = "" if at == 0 or text[at - 1] == "\n" else "\n"
    return f"{text[:at]}{before}{line}\n{text[at:]}"


def _table_region(text: str, table: KeyPath) -> tuple[int, int]:
    """What belongs to a table: from behind its header to the next one; (-1, -1) if it has none."""
    headers = [m.start() for m in re.finditer(r"^[^\S\n]*\[", text, re.MULTILINE)]
    if not table:
        return 0, headers[0] if headers else len(text)
    span = key_spans(text).get(table)
    if span is None:
        return -1, -1
    line = text.rfind("\n", 0, span.start) + 1
    if not text[line : span.start].lstrip().startswith("["):
        return -1, -1
    end = text.find("\n", span.end)
    start = len(text) if end < 0 else end + 1
    return start, min((at for at in headers if at >= start), default=len(text))


def _key_position(
    content: dict[str, Any] | None, values: Mapping[KeyPath, Any]
) -> dict[str, Any] | None:
    """None where a key would belong to what is no table, and for what no text says."""
    out = copy.deepcopy(content)
    for path, value in values.items():
        here: Any = out
        for key in path[:-1]:
            here = here.setdefault(key, {}) if isinstance(here, dict) else None
        said = {"it": None} if value is None else toml_content(f"it = {toml_value(value)}")
        if not isinstance(here, dict) or said is None:
            return None
        if value is None:
            here.pop(path[-1], None)
        else:
            here[path[-1]] = said["it"]
    return out


def toml_content(text: str) -> dict[str, Any] | None:
    """None for a text that is no TOML; raises Refused for one that takes too long to read."""
    try:
        return toml_text.parse_toml(text)
    except (ValueError, RecursionError):
        return None


def _toml_key(name: str) -> str:
    return name if BARE_KEY.fullmatch(name) else _toml_text(name)


def _toml_text(text: str) -> str:
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise not_asked("a text holds what is no character")
    return toml_quoted(text)


def without_table(text: str, table: KeyPath, name: str) -> str:
    """A text without a table and what it holds, with the comments in it. Raises Refused."""
    start, stop = _table_region(text, table)
    if start < 0:
        return text
    line = text.rfind("\n", 0, start - 1) + 1
    changed = text[:line] + text[stop:]
    meant = _key_position(toml_content(text), {table: None})
    if meant is None or toml_content(changed) != meant:
        key = ".".join(table)
        raise Refused(rules.NOT_KEPT(path=name, key=key, name=name))
    return changed

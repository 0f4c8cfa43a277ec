"""TOML texts changed in place, and values as TOML.

A text is changed by the lines of one key: only these are parsed and printed by `tomlkit`, which
takes seconds for a file of ten thousand lines. All other lines stay byte for byte. A change that
TOML would read as another one is not made.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Span
from assistant.base.toml_text import KeyPath, Section, next_line, sections, toml_content

if TYPE_CHECKING:
    from tomlkit.container import Container
    from tomlkit.items import Item, Key

COMMENT_COLUMN: Final = 30
"""Column of the comment after a new value."""
_REMARK: Final = re.compile(r"[^\S\n]#(?=[^#]*$)(.*)$")
_NEXT_REMARKS: Final = re.compile(r"(?<=\n)[^\S\n]*\n(?:[^\S\n]*#[^\n]*\n)+\Z")
"""Comments after a blank line at the end of a table: those of the next table."""
_LONGEST_ARRAY: Final = 100
"""Letters over which an array that gets entries has a line for each."""
_WHOLE_BELOW: Final = 1e15
"""From here on numbers are not written as integers."""

# ------------------------------------------------------------------------------------ values


def toml_value(value: Any) -> str:
    """A value as TOML in one line: tables and arrays in brackets, whole numbers without a point.

    Raises ValueError for what TOML cannot express.
    """
    return toml_item(value).as_string()


def toml_item(value: Any) -> Item:
    """A value for a document of `tomlkit`; see `toml_value`."""
    import tomlkit

    match value:
        case Mapping():
            table = tomlkit.inline_table()
            for key, one in value.items():
                table.append(_key([str(key)]), toml_item(one))
            return table
        case float() if value.is_integer() and abs(value) < _WHOLE_BELOW:
            return tomlkit.item(int(value))
        case str():
            # Raises ValueError for lone surrogates, which no TOML file can hold.
            value.encode()
            return tomlkit.string(value)
        case Sequence():
            array = tomlkit.array()
            for one in value:
                array.append(toml_item(one))
            return array
        case None:
            raise ValueError("TOML has no null")
    item: Item = tomlkit.item(value)
    return item


def toml_key(*parts: str) -> str:
    """A key as TOML, or a dotted one of several parts."""
    return _key(parts).as_string()


def toml_rows(array: Sequence[Any]) -> Item:
    """An array with a line for each entry."""
    import tomlkit

    item = tomlkit.array()
    for one in array:
        item.append(toml_item(one))
    item.multiline(True)
    return item


def toml_text(content: Mapping[str, Any]) -> str:
    """A TOML file without the keys that have no value.

    content: mappings become tables and lists of mappings arrays of tables, unless they are items
    already.
    """
    import tomlkit

    return tomlkit.dumps(_plain(content))


def rounded(numbers: Sequence[float], digits: int) -> list[float]:
    """Numbers with at most so many decimals."""
    # The sum turns -0.0 into 0.0.
    return [round(float(one), digits) + 0.0 for one in numbers]


def _plain(value: Any) -> Any:
    from tomlkit.items import Item

    match value:
        case Item():
            return value
        case Mapping():
            return {key: _plain(one) for key, one in value.items() if one is not None}
        case [Mapping(), *_]:
            return [_plain(one) for one in value]
    return toml_item(value)


def _key(parts: Sequence[str]) -> Key:
    import tomlkit

    # Raises ValueError for lone surrogates, which no TOML file can hold.
    for part in parts:
        part.encode()
    return tomlkit.key(parts[0] if len(parts) == 1 else list(parts))


# ------------------------------------------------------------------------------------ edits


def with_values(text: str, values: Mapping[KeyPath, Any]) -> str | None:
    """Return a text in which keys have these values; None removes a key or a dotted table.

    Entries of arrays go by their number from 0. A key that is commented out with `#`, as a choice,
    is replaced there. Returns None if the text is no TOML, or if other keys would change as well.
    Raises ValueError for a value that TOML cannot express.
    """
    content = toml_content(text)
    for path, value in values.items():
        if content is None or toml_content(text) is None or not _set(content, path, value):
            return None
        text = _with_value(text, path, value)
    return text if is_alike(toml_content(text), content) else None


def without_table(text: str, path: KeyPath) -> str | None:
    """Return a text without a table and its comments; None if anything else would change."""
    content = toml_content(text)
    if content is None or not _set(content, path, None):
        return None
    if (section := sections(text).get(path)) is not None:
        removed = text[section.header : section.stop]
        following = _NEXT_REMARKS.search(removed) if section.stop < len(text) else None
        kept = following[0].lstrip("\r\n") if following else ""
        text = text[: section.header] + kept + text[section.stop :]
    return text if is_alike(toml_content(text), content) else None


def with_line(text: str, key: str, value: Any, *, after: str) -> str:
    """Return the lines of a table with a new key after another one."""
    pairs = [span for path, span in sections(text)[()].pairs if path[0] == after]
    return _inserted(text, next_line(text, pairs[-1].end), _line([key], value))


def with_other_key(text: str, old: str, key: str, value: Any) -> str:
    """Return the lines of a table with another key in place of one, without its comment."""
    pairs = [span for path, span in sections(text)[()].pairs if path[0] == old]
    return _with_lines(text, pairs, _line([key], value))


def is_alike(one: Any, other: Any) -> bool:
    """True if two contents are the same; `nan` equals itself, `true` is no number."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(is_alike(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(is_alike, one, other))
    same = one == other or (one != one and other != other)
    return same and isinstance(one, bool) == isinstance(other, bool)


def _set(content: Any, path: KeyPath, value: Any) -> bool:
    """Set what a text is meant to hold; False where a key would belong to what is no table."""
    # The value as it is read back, to compare with the text that is read again.
    meant = None if value is None else (toml_content(f"it = {toml_value(value)}") or {}).get("it")
    here = content
    for part in path[:-1]:
        if value is None and isinstance(here, dict) and part not in here:
            return True  # there is nothing to remove
        here = here.setdefault(part, {}) if isinstance(here, dict) else _entry(here, part)
    if not isinstance(here, dict) or (value is not None and meant is None):
        return False
    if value is None:
        here.pop(path[-1], None)
    else:
        here[path[-1]] = meant
    return True


def _entry(array: Any, number: str) -> Any:
    here = isinstance(array, list) and number.isdigit() and int(number) < len(array)
    return array[int(number)] if here else None


def _with_value(text: str, path: KeyPath, value: Any) -> str:
    found = sections(text)
    for section in found.values():
        pairs = [one for one in section.pairs if one[0][: len(path)] == path[: len(one[0])]]
        if not pairs:
            continue
        names = path[len(section.path) :]
        # A shorter key holds an inline table or array; longer ones are the dotted keys of a table.
        (key, span), spans = pairs[0], [one for _, one in pairs]
        if len(key) < len(path) or (key == path and value is not None):
            return _with_changed_pair(text, span, names, value)
        return _with_lines(text, spans, None if value is None else _line(names, value))
    return text if value is None else _with_new_key(text, found, path, value)


def _with_changed_pair(text: str, span: Span, names: KeyPath, value: Any) -> str:
    """A comment after the value keeps its column as far as there is room."""
    import tomlkit

    start, end = text.rfind("\n", 0, span.start) + 1, next_line(text, span.end)
    document = tomlkit.parse(text[start:end])
    table: Any = document
    # Down to the innermost container that exists: the names that remain are new.
    while len(names) > 1 and (isinstance(table, list) or names[0] in table):
        key: Any = int(names[0]) if isinstance(table, list) else names[0]
        table, names = table[key], names[1:]
    # Levels that are missing become inline tables.
    for name in reversed(names[1:] if value is not None else ()):
        value = {name: value}
    if value is None:
        if len(names) > 1 or names[0] not in table:
            return text
        del table[names[0]]
    elif names[0] not in table:
        table.add(names[0], toml_item(value))
    else:
        before = document.as_string()
        if not _entries_changed(table[names[0]], value):
            table[names[0]] = toml_item(value)
        trivia = _only_value(document).trivia
        longer = len(document.as_string()) - len(before)
        # Only a comment on the line of the value has a column to keep.
        if trivia.comment and "\n" not in before[: before.index(trivia.comment)]:
            trivia.comment_ws = " " * max(1, len(trivia.comment_ws) - longer)
    changed = re.sub(r"(?<!\r)\n", _newline(text), document.as_string())
    return text[:start] + changed + text[end:]


def _entries_changed(array: Item, value: Any) -> bool:
    """Take entries out of an array and add others at its end; False if that is not all.

    The other entries keep their lines and comments.
    """
    from tomlkit.items import Array

    if not isinstance(array, Array) or not isinstance(value, Sequence) or isinstance(value, str):
        return False
    if any(isinstance(one, int | float) for one in value):
        return False  # comments beside the parts of a vector would be at others
    wanted, kept, gone = list(value), 0, list[int]()
    for i, one in enumerate(array.unwrap()):
        if kept < len(wanted) and is_alike(one, wanted[kept]):
            kept += 1
        else:
            gone.append(i)
    if not kept:
        return False
    for i in reversed(gone):
        del array[i]
    for one in wanted[kept:]:
        array.append(toml_item(one))
    text = array.as_string()
    if len(text) > _LONGEST_ARRAY and "\n" not in text:
        array.multiline(True)
    return True


def _only_value(table: Container) -> Item:
    """The value of the one pair of a document, under the parts of a dotted key."""
    from tomlkit.items import Table

    item = next(one for key, one in table.body if key is not None)
    return _only_value(item.value) if isinstance(item, Table) else item


def _with_lines(text: str, pairs: Sequence[Span], line: str | None) -> str:
    """With a line in place of the first of some pairs, without the others."""
    # The last one first, so that the spans before it stay valid.
    for span in reversed(pairs):
        start, end = text.rfind("\n", 0, span.start) + 1, next_line(text, span.end)
        ending = text[start + len(text[start:end].rstrip("\r\n")) : end]
        new = text[start : span.start] + line + ending if line and span is pairs[0] else ""
        text = text[:start] + new + text[end:]
    return text


def _with_new_key(text: str, found: Mapping[KeyPath, Section], path: KeyPath, value: Any) -> str:
    """At the key's commented-out choice in the table; else after the table's last key."""
    table = path[:-1]
    for section in found.values():
        dotted = [span for key, span in section.pairs if key[: len(table)] == table]
        if section.path != table and not (dotted and section.path == table[: len(section.path)]):
            continue
        line = _line(path[len(section.path) :], value)
        choice = _choice(text, section, path[-1]) if section.path == table else None
        if choice is not None:
            # Without the first `#`, which makes the line a choice.
            about = _REMARK.search(choice[0][1:])
            line = f"{line:{COMMENT_COLUMN - 1}} #{about[1]}" if about else line
            return text[: choice.start()] + line + text[choice.end() :]
        last = [span for _, span in section.pairs] if section.path == table else dotted
        return _inserted(text, next_line(text, last[-1].end) if last else section.start, line)
    header = f"[{toml_key(*table)}]"
    gap = "" if not text else _newline(text) * (1 if text.endswith("\n") else 2)
    return _inserted(text + gap + header, len(text + gap + header), _line(path[-1:], value))


def _choice(text: str, section: Section, key: str) -> re.Match[str] | None:
    """The comment that has a key and a value for it."""
    choices = re.compile(rf"^# *{re.escape(toml_key(key))} *=[^\r\n]*", re.MULTILINE)
    for found in choices.finditer(text, section.start, section.stop):
        # A line inside a multi-line value is no comment.
        if not any(span.start <= found.start() < span.end for _, span in section.pairs):
            return found
    return None


def _line(names: Sequence[str], value: Any) -> str:
    return f"{toml_key(*names)} = {toml_value(value)}"


def _inserted(text: str, at: int, line: str) -> str:
    """With a new line at the start of another one, or at the end of the text."""
    newline = _newline(text)
    before = "" if at == 0 or text[at - 1] == "\n" else newline
    return f"{text[:at]}{before}{line}{newline}{text[at:]}"


def _newline(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"

"""Process files in forms: the layers of a drawing, and values put into a TOML text.

Comments, order and layout of the text stay as they are; an edit that TOML would read differently is
refused. Lines of a drawing are points from above in mm.
"""

from __future__ import annotations

import copy
import json
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base import toml_text
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.file_access import read_file
from assistant.base.file_sets import write_all
from assistant.base.source_text import SourceText, encode, is_file
from assistant.base.toml_text import KeyPath, key_spans, value_spans
from assistant.project.new_project import COMMENT_COLUMN, process_text, toml_quoted
from assistant.sources import PROCESS_SUFFIX, process_of
from assistant.sources.drawing import read_contents
from assistant.sources.drawing.survey import Survey, SurveyedLayer, survey
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.process.file import parse_process
from assistant.studio import rules
from assistant.studio.route_answers import finding_records, not_asked, plain_value
from assistant.studio.studio import Studio

_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
_TRAILING_COMMENT: Final = re.compile(r"[^\S\n]*(#[^\n]*)?$")


def with_values(text: str, values: Mapping[KeyPath, Any], name: str) -> str:
    """Return a text in which keys have these values; None removes a key.

    A key that is commented out with `#`, as a choice, is replaced there. Raises Refused if anything
    else in the text would change its meaning. name: of the file, for the finding.
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
    """Return the text with the value replaced; a comment after it keeps its column as far as there
    is room.
    """
    stop = text.find("\n", end)
    rest = text[end : stop if stop >= 0 else len(text)]
    match = _TRAILING_COMMENT.match(rest)
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
    """Return the text with a new key: at its commented-out choice in the table; else after the
    table's last line.
    """
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
    """Return the region of a table: from after its header to the next one; (-1, -1) if it is
    missing.
    """
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
    """Return the TOML contents, None for invalid TOML; raise Refused for a text that takes too long
    to read.
    """
    try:
        return toml_text.parse_toml(text)
    except (ValueError, RecursionError):
        return None


def _toml_key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _toml_text(name)


def _toml_text(text: str) -> str:
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise not_asked("a text holds what is no character")
    return toml_quoted(text)


def _without_table(text: str, table: KeyPath, name: str) -> str:
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


_LEAVE_OUT_KEY: Final = "leave_out"
_LAYERS_TABLE: Final = "layers"
_USED_FIELD: Final = "used"
"""Field of a layer that says whether it is worked; every other field is a key of its table."""
_MOST_DRAWN_POINTS: Final = 20_000
"""Most points in the picture of a drawing."""
_CHORD_SHARE: Final = 0.0002
"""Parts of a drawing's size that chords of a curve are off in its picture, less than is seen."""
_FORM_FIELDS: Final = (
    ("tools", "tool", "tip"),
    ("frames", "work", "position"),
    ("frames", "work", "euler_zyx"),
    ("placement", "position"),
    ("placement", "euler_zyx"),
    ("motion", "speed"),
)
"""Fields of the page other than layers, in its order, by the names of a new process file."""
_CHOSEN_ENTRIES: Final = {"tools": "tool", "frames": "frame"}
"""Which of a table's entries the motion takes, under `[motion]`."""


def drawing_layers(studio: Studio, path: str) -> dict[str, Any]:
    """Return a drawing's contents, the use of each layer, and its lines from above."""
    drawing = studio.file(path)
    file = drawing.with_suffix(PROCESS_SUFFIX)
    content, process, found = _process_contents(drawing, file)
    seen = survey(drawing, process)
    tables = content.get(_LAYERS_TABLE, {})
    named = {name.casefold(): table for name, table in tables.items()}
    return {
        "path": path,
        "process": studio.named(file) if is_file(file) else None,
        "unit": seen.unit,
        "layers": [
            {
                "name": one.name,
                "closed": one.closed,
                "open": one.open,
                "length": round(one.length, 3),
                "locations": one.locations,
                "use": one.use,
                _USED_FIELD: _is_worked(one, process),
                "values": plain_value(named.get(one.name.casefold(), {})),
            }
            for one in seen.layers
            if one.kinds
        ],
        "values": _field_values(content),
        "lines": _drawn_lines(drawing, process),
        "findings": finding_records([*seen.findings, *found]),
    }


def _field_values(content: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the values of `FIELDS` in a file, with its names of tool and frame.

    A rotation given as a quaternion is not a field.
    """
    found = []
    for field in _FORM_FIELDS:
        table, *rest = field
        said = _value_at(content, ("motion", _CHOSEN_ENTRIES.get(table, "")))
        key = (table, said, *rest[1:]) if isinstance(said, str) else field
        if rest[-1] == "euler_zyx" and _value_at(content, (*key[:-1], "quaternion")) is not None:
            continue
        value = plain_value(_value_at(content, key))
        found.append({"field": ".".join(field), "key": list(key), "value": value})
    return found


def _is_worked(layer: SurveyedLayer, process: Process) -> bool:
    something = layer.works or layer.locations > 0
    return something and layer.state == "on" and not process.leaves_out(layer.name)


def write_process(studio: Studio, path: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Write the process file of a drawing with these values, creating it if necessary.

    values: tables in tables, as the file has them; None removes a key. Raises Refused for values
    that would make the file unreadable, and then writes nothing.
    """
    drawing = studio.file(path)
    file = drawing.with_suffix(PROCESS_SUFFIX)
    before = _process_text(drawing, file)
    _check_tables(before)
    text = before.text
    wanted = dict(values)
    for name, table in _table_names(wanted.pop(_LAYERS_TABLE, {})).items():
        used = table.pop(_USED_FIELD, None)
        text = _with_use(text, name, used, file.name) if isinstance(used, bool) else text
        if used is not False:
            text = with_values(
                text, {(_LAYERS_TABLE, name, k): v for k, v in table.items()}, file.name
            )
    text = with_values(text, dict(_flat_keys(wanted)), file.name)
    changed = replace(before, text=text)
    _refuse_new_errors(before, changed)
    write_all({file: encode(changed)})
    return drawing_layers(studio, path)


def _with_use(text: str, name: str, used: bool, file: str) -> str:
    content = toml_content(text) or {}
    out = [one for one in content.get(_LEAVE_OUT_KEY, []) if one != name]
    if not used:
        known = next(
            (k for k in content.get(_LAYERS_TABLE, {}) if k.casefold() == name.casefold()), None
        )
        text = text if known is None else _without_table(text, (_LAYERS_TABLE, known), file)
        out.append(name)
    if out != content.get(_LEAVE_OUT_KEY, []):
        text = with_values(text, {(_LEAVE_OUT_KEY,): out}, file)
    if used and name not in content.get(_LAYERS_TABLE, {}):
        text = with_values(text, {(_LAYERS_TABLE, name, "speed"): 50}, file)
    return text


def _check_tables(source: SourceText) -> None:
    """Raises Refused, with its own findings, for a file that layers cannot be put into."""
    content = toml_content(source.text)
    content = {_LAYERS_TABLE: None} if content is None else content
    tables, out = content.get(_LAYERS_TABLE, {}), content.get(_LEAVE_OUT_KEY, [])
    if not (isinstance(tables, dict) and isinstance(out, list)):
        raise Refused(*_process_errors(source))


def _refuse_new_errors(before: SourceText, changed: SourceText) -> None:
    """Raises Refused for errors that were not there before."""
    found = _process_errors(changed)
    new = Counter(map(_layer_record, found)) - Counter(map(_layer_record, _process_errors(before)))
    if new:
        raise Refused(*(one for one in found if _layer_record(one) in new))


def _layer_record(finding: Diagnostic) -> tuple[str, str]:
    return finding.code, finding.message


def _process_errors(source: SourceText) -> tuple[Diagnostic, ...]:
    try:
        parse_process(source)
    except Refused as refused:
        return refused.findings if has_errors(refused.findings) else ()
    return ()


def _process_contents(
    drawing: FilePath, file: FilePath
) -> tuple[dict[str, Any], Process, list[Any]]:
    """Return the process file as written and as parsed; a blank one without its blanks."""
    if not is_file(file):
        return {}, NO_PROCESS, []
    source = _process_text(drawing, file)
    content = toml_content(source.text) or {}
    try:
        return content, process_of(drawing), []
    except Refused as refused:
        wanted = {"unit": content.get("unit"), _LEAVE_OUT_KEY: content.get(_LEAVE_OUT_KEY)}
        left = wanted[_LEAVE_OUT_KEY] if isinstance(wanted[_LEAVE_OUT_KEY], list) else []
        unit = wanted["unit"] if isinstance(wanted["unit"], str) else None
        names = tuple(one for one in left if isinstance(one, str))
        return content, _half_of_key(content, unit, names), list(refused.findings)


def _half_of_key(content: Mapping[str, Any], unit: str | None, left: tuple[str, ...]) -> Process:
    from assistant.base.length_units import known_unit
    from assistant.sources.process import DEFAULT_MOTION, Layer

    found = replace(NO_PROCESS, leave_out=left)
    tables = content.get(_LAYERS_TABLE, {})
    named = tables if isinstance(tables, dict) else {}
    kept = {name: Layer(name, DEFAULT_MOTION.motion) for name in named}
    try:
        return replace(found, layers=kept, unit=None if unit is None else known_unit(unit))
    except Refused:
        return replace(found, layers=kept)


def _process_text(drawing: FilePath, file: FilePath) -> SourceText:
    if not is_file(file):
        seen: Survey = survey(drawing, NO_PROCESS)
        return SourceText(process_text(drawing.name, seen), str(file), "utf-8", "\n")
    from assistant.base.source_text import decode
    from assistant.program.settings_tables import ENCODINGS

    return decode(read_file(file), str(file), ENCODINGS)


def _drawn_lines(drawing: FilePath, process: Process) -> list[dict[str, Any]]:
    """Curves from above, in mm of the drawing, as far as there is room."""
    import numpy as np

    from assistant.sources.contours.curves import chorded, sample

    found, room = [], _MOST_DRAWN_POINTS
    curves = read_contents(drawing, replace(process, placement=None)).curves
    if not curves:
        return []
    size = float(np.ptp(sample(curves, (0.0, 0.3, 0.6, 1.0))[..., :2], axis=(0, 1)).max())
    off = max(size * _CHORD_SHARE, process.tolerance)
    for curve in curves:
        points = chorded(curve, off)[:, :2]
        room -= len(points)
        if room < 0:
            break
        found.append({"layer": curve.layer, "points": np.round(points, 3).tolist()})
    return found


def _table_names(value: Any) -> dict[str, dict[str, Any]]:
    if not isinstance(value, dict) or not all(isinstance(one, dict) for one in value.values()):
        raise not_asked("`layers` is no table of tables")
    return {name: dict(table) for name, table in value.items()}


def _flat_keys(values: Mapping[str, Any], path: KeyPath = ()) -> list[tuple[KeyPath, Any]]:
    found: list[tuple[KeyPath, Any]] = []
    for key, value in values.items():
        here = (*path, key)
        found += _flat_keys(value, here) if isinstance(value, dict) else [(here, value)]
    return found


def _value_at(content: Mapping[str, Any], path: KeyPath) -> Any:
    here: Any = content
    for key in path:
        here = here.get(key) if isinstance(here, dict) else None
    return here

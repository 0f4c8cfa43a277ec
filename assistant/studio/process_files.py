"""Process files in forms: the layers of a drawing, and values put into a TOML text.

Comments, order and layout of the text stay as they are; an edit that TOML would read differently is
refused. Lines of a drawing are points from above in mm.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base import toml_edits
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.file_access import read_file
from assistant.base.file_sets import write_all
from assistant.base.source_text import SourceText, encode, is_file
from assistant.base.toml_text import KeyPath, toml_content
from assistant.program import settings_tables
from assistant.project.new_project import PROJECT_FILE, process_text
from assistant.sources import PROCESS_SUFFIX, process_of
from assistant.sources.drawing import read_contents
from assistant.sources.drawing.survey import Survey, SurveyedLayer, survey
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.process.file import parse_process
from assistant.studio import rules
from assistant.studio.drawn_contours import DrawnContours, left_out_entries, with_choices
from assistant.studio.route_answers import finding_records, not_asked, plain_value
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.project.project_file import Project
    from assistant.report.contour_plot import DrawnLine


def with_values(text: str, values: Mapping[KeyPath, Any], name: str) -> str:
    """Return a text in which keys have these values; see `toml_edits.with_values`.

    Raises Refused if anything else in the text would change its meaning. name: of the file, for the
    finding.
    """
    try:
        changed = toml_edits.with_values(text, values)
    except ValueError as error:
        raise not_asked(f"a TOML file cannot hold that: {error}") from None
    return _unless_kept(changed, next(iter(values), ()), name)


def _without_table(text: str, table: KeyPath, name: str) -> str:
    """A text without a table and what it holds, with the comments in it. Raises Refused."""
    return _unless_kept(toml_edits.without_table(text, table), table, name)


def _unless_kept(changed: str | None, path: KeyPath, name: str) -> str:
    if changed is None:
        raise Refused(rules.NOT_KEPT(path=name, key=".".join(path), name=name))
    return changed


_LEAVE_OUT_KEY: Final = "leave_out"
_LAYERS_TABLE: Final = "layers"
_USED_FIELD: Final = "used"
"""Field of a layer that says whether it is worked; every other field is a key of its table."""
_CONTOURS_FIELD: Final = "contours"
"""Field of the form for single contours, which go into `leave_out`."""
_FORM_FIELDS: Final = (
    ("tools", "tool", "tip"),
    ("frames", "work", "position"),
    ("frames", "work", "euler_zyx"),
    ("placement", "position"),
    ("placement", "euler_zyx"),
    ("motion", "speed"),
)
"""Fields of the page other than layers, in its order, by the names of a new process file."""
_POSITION_FIELD: Final = "frames.work.position"
_TURN_FIELD: Final = "frames.work.euler_zyx"
_POSE_FIELDS: Final = (_TURN_FIELD, "placement.position", "placement.euler_zyx")
_NO_TURNS: Final[tuple[Any, ...]] = (None, [], [0, 0, 0])
_ROBOT_KEY: Final = "robot"
"""Key of the arm, in a program's entry of the project file, else at the top of a process file."""
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
                "drafting": one.drafting,
                "parts": [
                    {"what": part.what, "name": part.name, "kind": part.kind, "count": part.count}
                    for part in one.parts
                ],
                _USED_FIELD: _is_worked(one, process),
                "values": plain_value(named.get(one.name.casefold(), {})),
            }
            for one in seen.layers
            if one.kinds
        ],
        "values": _with_proposal(
            [_robot_field(studio, drawing, content), *_field_values(content)], studio, seen
        ),
        "signals": _signal_records(content),
        **DrawnContours.of(drawing, process).records(numbered=_has_order(process, found)),
        "findings": finding_records([*seen.findings, *found]),
    }


def _has_order(process: Process, found: Sequence[Diagnostic]) -> bool:
    """True if the order of contours is that of the program: it is complete, and no cell has a part
    in it.
    """
    return not has_errors(found) and not process.defaults.travels


def _field_values(content: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the values of `FIELDS` in a file, with its names of tool and frame.

    A rotation given as a quaternion is not a field.
    """
    chosen = _value_at(content, ("motion", "tool"))
    tools = content.get("tools", {})
    names = list(tools) if isinstance(tools, dict) else []
    tool = {"field": "motion.tool", "key": ["motion", "tool"], "value": chosen, "choices": names}
    found = [tool] if isinstance(chosen, str) and chosen in names else []
    for field in _FORM_FIELDS:
        table, *rest = field
        said = _value_at(content, ("motion", _CHOSEN_ENTRIES.get(table, "")))
        key = (table, said, *rest[1:]) if isinstance(said, str) else field
        if rest[-1] == "euler_zyx" and _value_at(content, (*key[:-1], "quaternion")) is not None:
            continue
        value = plain_value(_value_at(content, key))
        found.append({"field": ".".join(field), "key": list(key), "value": value})
    return found


def _with_proposal(
    fields: list[dict[str, Any]], studio: Studio, seen: Survey
) -> list[dict[str, Any]]:
    """Return the fields of a form; a blank position of the work has a proposal, the values of a new
    project, unless the user has turned the work or placed the drawing in its frame.
    """
    from assistant.project.first_values import first_values

    known = {one["field"]: one for one in fields}
    given = {name: one["value"] for name, one in known.items()}
    unturned = all(given.get(name, True) in _NO_TURNS for name in _POSE_FIELDS)
    if given.get(_POSITION_FIELD) != [] or not unturned:
        return fields
    robot = given[_ROBOT_KEY] or next(iter(_controller_robots(studio)), None)
    try:
        tip = settings_tables.position(given["tools.tool.tip"]) if given["tools.tool.tip"] else None
        found = first_values(seen.extents, robot, tip=tip)
    except (Refused, settings_tables.Wrong):
        return fields
    if found.reached:
        place = known[_POSITION_FIELD]
        stated = found.keys("position")
        place["proposed"] = {
            _POSITION_FIELD: stated["position"],
            **({_TURN_FIELD: stated["euler_zyx"]} if any(stated["euler_zyx"]) else {}),
            **({} if robot else {_ROBOT_KEY: found.robot_name}),
        }
        place["robot"] = found.robot.title
    return fields


def common_robot(studio: Studio) -> str | None:
    """Return the robot that all controllers of a project have, None if they differ."""
    named = _controller_robots(studio)
    return named[0] if len({*named}) == 1 else None


def _controller_robots(studio: Studio) -> list[str]:
    """Return the robots of a project's controllers; none of a project that is wrong."""
    from assistant.project.first_values import controller_robots

    try:
        return controller_robots(studio.folder)
    except Refused:
        return []


def _signal_records(content: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the outputs of a process file with the numbers that controllers count them by."""
    tables = content.get("signals", {})
    return [
        {"name": name, "number": plain_value(table.get("number"))}
        for name, table in (tables if isinstance(tables, dict) else {}).items()
        if isinstance(table, dict) and table.get("direction", "output") == "output"
    ]


def _robot_field(studio: Studio, drawing: FilePath, content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arm of a drawing's program, empty for that of its controller."""
    from assistant import robots

    entry = _program_entry(studio, drawing)
    stated = content.get(_ROBOT_KEY) if entry is None else _value_at(*entry[1:])
    value = stated if isinstance(stated, str) else ""
    choices = ["", *sorted({*robots.names(), value} - {""})]
    return {"field": _ROBOT_KEY, "key": [_ROBOT_KEY], "value": value, "choices": choices}


def _program_entry(
    studio: Studio, drawing: FilePath
) -> tuple[FilePath, dict[str, Any], KeyPath] | None:
    """Return the project file, its contents, and the key of the robot of a drawing's program."""
    from assistant.project import project_of

    try:
        project = project_of(studio.folder)
    except Refused:
        return None
    names = [n for n, one in project.programs.items() if one.source.resolve() == drawing.resolve()]
    content = toml_content(read_file(project.file).decode("utf-8")) if names else None
    if content is None:
        return None
    return project.file, content, (*project_table(project), "programs", names[0], _ROBOT_KEY)


def project_table(project: Project) -> KeyPath:
    """Return the table of a project in its file."""
    return () if project.file.name == PROJECT_FILE else ("tool", "robot-assistant")


def _is_worked(layer: SurveyedLayer, process: Process) -> bool:
    something = (layer.works and not layer.drafting) or layer.locations > 0
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
    written: dict[FilePath, bytes] = {}
    contours = wanted.pop(_CONTOURS_FIELD, None)
    entry = _program_entry(studio, drawing) if _ROBOT_KEY in wanted else None
    if entry is not None:
        written[entry[0]] = _with_robot(*entry, wanted.pop(_ROBOT_KEY))
    for name, table in _table_names(wanted.pop(_LAYERS_TABLE, {})).items():
        used = table.pop(_USED_FIELD, None)
        text = _with_use(text, name, used, file.name) if isinstance(used, bool) else text
        if used is not False:
            text = with_values(
                text, {(_LAYERS_TABLE, name, k): v for k, v in table.items()}, file.name
            )
    text = with_values(text, dict(_flat_keys(wanted)), file.name)
    if contours:
        drawn = DrawnContours.of(drawing, _process_contents(drawing, file)[1])
        entries = (toml_content(text) or {}).get(_LEAVE_OUT_KEY, [])
        chosen = with_choices(entries, drawn, contours)
        text = with_values(text, {(_LEAVE_OUT_KEY,): chosen}, file.name)
    changed = replace(before, text=text)
    _refuse_new_errors(before, changed)
    write_all(written | {file: encode(changed)})
    return drawing_layers(studio, path)


def _with_robot(file: FilePath, _: Mapping[str, Any], key: KeyPath, name: object) -> bytes:
    """The project file with the arm of a program; None for that of its controller."""
    from assistant import robots

    if name is not None and name not in robots.names():
        raise not_asked("`robot` is no robot of the catalogue")
    return with_values(read_file(file).decode("utf-8"), {key: name}, file.name).encode("utf-8")


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
        return content, _half_of_key(content, unit, left), list(refused.findings)


def _half_of_key(content: Mapping[str, Any], unit: str | None, left: Sequence[Any]) -> Process:
    from assistant.base.length_units import known_unit
    from assistant.sources.process import DEFAULT_MOTION, Layer

    names = tuple(one for one in left if isinstance(one, str))
    found = replace(NO_PROCESS, leave_out=names, left_out=left_out_entries(left))
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


def unplaced_lines(drawing: FilePath) -> list[DrawnLine]:
    """Return the lines of a drawing as they are drawn, whatever its process file lacks."""
    from assistant.report.contour_plot import lines_of

    _, process, _ = _process_contents(drawing, drawing.with_suffix(PROCESS_SUFFIX))
    unplaced = replace(process, placement=None)
    return lines_of(read_contents(drawing, unplaced), unplaced)


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

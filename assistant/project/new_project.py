"""A new project: a working example, the user's drawings, and what a repository needs.

The process file of a drawing lists its layers. What would move a robot wrongly if it were guessed,
the tip of the tool and the place of the work, is left empty: until the user fills it in, every
command says so and writes nothing. Files that are there are never overwritten.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Final

from assistant import __version__
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.base.file_access import read_file
from assistant.base.file_sets import write_all
from assistant.base.length_units import UNITS, known_unit
from assistant.base.source_text import ended_lines, read_bytes
from assistant.base.toml_edits import COMMENT_COLUMN, toml_key, toml_text, toml_value
from assistant.program.program import TakenNames, identifier
from assistant.program.project_file import read_project
from assistant.program.settings_tables import shown
from assistant.project import rules
from assistant.project.first_values import FirstValues, robot_text
from assistant.project.project_file import SCHEMA_FILE, project_of, schema_text
from assistant.resources import resource
from assistant.sources import PROCESS_SUFFIX
from assistant.sources.drawing.drafting import BORDER
from assistant.sources.drawing.findings import NO_BLOCK
from assistant.sources.drawing.survey import Extents, Survey, SurveyedLayer, survey
from assistant.sources.process import NO_PROCESS

BLANK_KEYS: Final = ("`tip` of [tools.tool]", "`position` of [frames.work]")
"""Keys that must be filled in before anything moves."""

TOP_ROWS: Final = (
    ("# home = [0, 0, 0, 0, 30, 0]", "of the axes: there the program begins and ends, with"),
    ('# robot = "irb1200-7-0.7"', "whose axes these are"),
    ("# joint_percent = 20", "of joint moves, for controllers that take no mm/s"),
)
_MOTION_ROWS: Final = (
    ("speed = 100", "mm/s, where a layer or a location says no other"),
    ('tool = "tool"', "defined below"),
    ('frame = "work"', "defined below; base is the robot's own"),
    ("# blend = 1", 'mm of rounding at corners, or "fine"; without it within the tolerance'),
    ("# approach = 50", "mm in a line to locations, along the tool"),
    ("# retract = 50", "and away from them"),
    ('# kind = "joint"', "moves to locations; linear without it"),
)
_TOOL_ROWS: Final = (
    ("tip = []", "mm: x, y, z of the tool centre point in the flange frame"),
    ("euler_zyx = [0, 0, 0]", "degrees about z, y, x that the tool is turned in the flange"),
    ("# mass = 1.2", "kg; with it also the next"),
    ("# centre = [0, 0, 60]", "mm, of gravity"),
    ("# free_turn = true", "a round tool, which may be turned about its axis"),
)
_FRAME_TURN_ROW: Final = ("euler_zyx = [0, 0, 0]", "degrees about z, y, x")
_PLACEMENT_ROWS: Final = (
    ("# [placement]", "where the drawing stands in that frame, if not at its origin"),
    ("# position = [0, 0, 0]", "mm; or three marks, as drawn and as taught, instead:"),
    ("# euler_zyx = [0, 0, 0]", "degrees about z, y, x"),
    ("# drawing = [[0, 0], [100, 0], [0, 50]]", ""),
    ("# cell = [[0, 0, 0], [100, 0, 0], [0, 50, 0]]", ""),
)
_SIGNAL_ROWS: Final = (
    ("# [signals.work_on]", "that layers switch by `on` and `off`"),
    ('# direction = "output"', ""),
    ("# number = 8", "for controllers that count signals"),
)
LAYER_ROWS: Final = (
    ("speed = 50", "mm/s along the contours"),
    ("approach = 50", "mm above the first point, along the tool"),
    ("retract = 50", "mm above the last one"),
    ("travel = 200", "mm/s between contours"),
)
CHOICE_KEYS: Final = (
    ('# process = "gluing"', "for people"),
    ("# blend = 1", 'mm, or "fine"'),
    ("# on = {work_on = 1}", "outputs at the start of each contour"),
    ("# off = {work_on = 0}", "and at its end"),
    ("# delay = 0.2", "seconds after switching on"),
    ("# direction = [0, 0, -1]", "where the tool points, in the drawing"),
    ("# tangential = true", "the tool's x axis follows the contour"),
    ("# inside_first = false", "contours inside others need not come first"),
    ("# offset = 3", "mm to the tool's centre: its radius, or half a kerf"),
    ('# side = "nesting"', "outlines outside, holes inside; or inside, outside, left, right"),
    ('# way_round = "climb"', "or conventional, clockwise, anticlockwise, drawn"),
    ('# start = "nearest"', "of closed contours; or corner, longest, point"),
    ("# lead_in = {arc = 5, angle = 90}", "or {line = 5, angle = 60}, {tangent = 5}"),
    ("# lead_out = {line = 5}", "on the side where the tool is"),
    ("# overlap = 8", "mm that a closed contour goes on over its own start"),
    ("# depth = 12", "mm of the last pass below the drawing, along the tool"),
    ("# passes = 3", "equal steps down to it"),
    ("# allowances = [0.5, 0]", "mm more than the offset, once around for each"),
    ('# order = "travel"', 'or "drawing"; "text": by the numbers beside contours'),
    ("# corner_speed = 20", "mm/s at corners, with the next three"),
    ("# corner_angle = 30", "degrees; turns by fewer are no corners"),
    ("# corner_radius = 0", "mm; arcs of up to that radius are corners too"),
    ("# corner_length = 5", "mm before and behind them"),
    ("# start_speed = 30", "mm/s over the first mm, with the next"),
    ("# start_length = 5", "mm"),
    ("# end_speed = 30", "mm/s over the last mm, with the next"),
    ("# end_length = 5", "mm"),
    ("# on_before = {seconds = 0.03}", "`on` before the start; mm, seconds or both"),
    ("# on_after = {mm = 5}", "or `on` that far behind it"),
    ("# off_before = {mm = 5}", "`off` before the end; mm, seconds or both"),
    ("# off_after = {mm = 5}", "or `off` behind it, mm or seconds"),
    ("# travel_height = 80", "mm above the highest point of the layer, for retract"),
    ("# travel_blend = 10", 'mm at the places above the work; "fine" without it'),
    ('# travel_kind = "linear"', "or joint; without it joint where the tool would wind up"),
)
"""Keys of a layer that are listed once."""

_KeyRow = tuple[str, str]


def process_text(name: str, survey: Survey, values: FirstValues | None = None) -> str:
    """The process file of a drawing by its name. values: None to leave blank what they state."""
    return "\n".join(_process_lines(name, survey, values)) + "\n"


def _process_lines(name: str, survey: Survey, values: FirstValues | None) -> Iterator[str]:
    works = [layer for layer in survey.layers if layer.works and not layer.drafting]
    idle = [layer for layer in survey.layers if layer.kinds and not _is_worked(layer)]
    yield f"# How {shown(name, 80)} is worked: lengths in mm, speeds in mm/s, times in seconds,"
    yield "# angles in degrees, masses in kg. A line with a # before its key is a choice: take the"
    yield (
        "# mark away to have it. Empty brackets have to be filled in before anything moves."
        if values is None
        else "# mark away to have it."
    )
    yield ""
    yield from _commented_rows(
        [*_unit_rows(survey), ("tolerance = 0.05", "for joining ends, fitting curves")]
    )
    yield from _drafting_rows(survey.layers)
    yield from _commented_rows([_left_out_row(idle, works, survey.missing)])
    if values is not None and values.assumed:
        about = "nobody measured these: take out what you did"
        yield from _commented_rows([(f"assumed = {toml_value(values.assumed_words)}", about)])
    yield from _commented_rows(TOP_ROWS)
    yield ""
    yield "[motion]"
    yield from _commented_rows(_MOTION_ROWS)
    yield ""
    yield "[tools.tool]"
    yield from _commented_rows(_with_value(_TOOL_ROWS, values, "tip"))
    yield ""
    yield from _commented_rows(
        [("[frames.work]", "where the drawing's origin stands, in the robot's base")]
    )
    standing = [("position = []", f"mm; {_extent_text(survey.extents)}"), _FRAME_TURN_ROW]
    yield from _commented_rows(_with_value(standing, values, "position"))
    for rows in (_PLACEMENT_ROWS, _SIGNAL_ROWS):
        yield ""
        yield from _commented_rows(rows)
    for number, layer in enumerate(works):
        yield ""
        yield f"[{toml_key('layers', _encodable(layer.name))}]"
        yield f"# {_layer_content(layer)}"
        yield from _commented_rows(LAYER_ROWS)
        yield from _commented_rows(CHOICE_KEYS if not number else ())


def _with_value(rows: Sequence[_KeyRow], values: FirstValues | None, key: str) -> Iterator[_KeyRow]:
    """Rows of which one, and the rotation beside it, has the values of the user."""
    stated = {} if values is None else values.keys(key)
    for row, about in rows:
        name = row.split(" = ")[0]
        if name in stated:
            if name == key and values is not None and values.assumes(key):
                about = f"assumed, measure it! {about}"
            yield f"{name} = {toml_value(stated[name])}", about
        else:
            yield row, about


def _is_worked(layer: SurveyedLayer) -> bool:
    return (layer.works and not layer.drafting) or layer.locations > 0


def _unit_rows(survey: Survey) -> Iterator[_KeyRow]:
    short = next((key for key, (name, _) in UNITS.items() if name == survey.unit), None)
    if short is None:
        yield f"# the drawing is in {survey.unit}", "which it says itself"
    else:
        size = "" if survey.extents is None else f": it is {_size_text(survey.extents)} mm then"
        yield f"unit = {toml_value(short)}", f"{survey.stated}{size}"


def _drafting_names(layers: Sequence[SurveyedLayer]) -> Iterator[str]:
    """What of a drawing is not work, and what it is."""
    for one in layers:
        if one.drafting:
            yield f"{shown(one.name)} ({one.drafting})"
    for layer in layers:
        for part in layer.parts:
            where = f"{part.what} {shown(part.name)} on {shown(layer.name)}"
            yield f"{where} ({part.kind}, {part.count})"


def _drafting_rows(layers: Sequence[SurveyedLayer]) -> Iterator[str]:
    """Say what is left out as it is drafting, and how it is had."""
    rows = list(_drafting_names(layers))
    if rows:
        yield "# Left out as drafting, by the names of layers, blocks and line types, or by shape:"
        yield from (f"#   {row}" for row in rows)
        yield "# A layer is followed if it has a table below, [layers.NAME]; a line type or a block"
        yield "# if its entry is deleted here."
        if any(part.what == BORDER for layer in layers for part in layer.parts):
            yield f'# A border is followed with follow = ["{BORDER}"].'


def _left_out_row(
    idle: Sequence[SurveyedLayer], works: Sequence[SurveyedLayer], missing: Sequence[str]
) -> _KeyRow:
    names: list[str | dict[str, str]] = [_encodable(layer.name) for layer in idle]
    names += [
        {"layer": _encodable(layer.name), part.what.replace(" ", "_"): _encodable(part.name)}
        for layer in works
        for part in layer.parts
        if part.what != BORDER  # known by its shape, so that no entry is needed
    ]
    names += [{"block": _encodable(name)} for name in missing]
    about = "nothing there is followed" if names else '["*"]: all that have no table here'
    return f"leave_out = {toml_value(names)}", about


def _layer_content(layer: SurveyedLayer) -> str:
    """Return a description of a layer's contents, for a comment."""
    contours = [f"{n} {what}" for n, what in ((layer.closed, "closed"), (layer.open, "open")) if n]
    said = [f"contours: {', '.join(contours)}, {layer.length:.1f} mm in all"]
    if layer.extents is not None:
        said.append(f"size {_size_text(layer.extents)} mm")
    if layer.colour is not None:
        said.append(f"colour {layer.colour}")
    if layer.state != "on":
        said.append(f"the layer is {layer.state}")
    return "; ".join(said)


def _extent_text(extents: Extents | None) -> str:
    if extents is None:
        return "nothing is drawn"
    low, high = (", ".join(f"{x:.1f}" for x in corner) for corner in (extents.low, extents.high))
    return f"from there it reaches from [{low}] to [{high}]"


def _size_text(extents: Extents) -> str:
    return " x ".join(f"{length:.1f}" for length in extents.size)


def _commented_rows(rows: Iterable[_KeyRow]) -> Iterator[str]:
    for key, about in rows:
        yield f"{key:{COMMENT_COLUMN - 1}} # {about}" if about else key


def _encodable(name: str) -> str:
    """A name without characters that no file can hold."""
    return name.encode("utf-8", "replace").decode("utf-8")


def _program_text(sources: Mapping[str, str], values: FirstValues | None) -> str:
    """Tables of programs, by their names, of sources as paths from the project's folder."""
    other = values is not None and values.language != values.robot.languages[0]
    language = {"language": values.language} if values is not None and other else {}
    return toml_text(
        {"programs": {name: {"source": path, **language} for name, path in sources.items()}}
    )


PROJECT_FILE: Final = "assistant.toml"
_EXAMPLE_DRAWING: Final[Mapping[str, str]] = {
    "drawings/plate.dxf": "drawings/plate.dxf",
    "drawings/plate.process.toml": "drawings/plate.process.toml",
}
"""Files of the example's drawing → their templates."""
EXAMPLE_FILES: Final = (*_EXAMPLE_DRAWING, PROJECT_FILE)
"""Files of the example; written where there is no project yet and no drawing is given.

The project is the last: who is killed before it begins anew.
"""
_EXAMPLE_PROGRAM: Final = """\
[programs.plate]
source = "drawings/plate.dxf"     # with drawings/plate.process.toml beside it
"""
_EXAMPLE_NAMES: Final = '["plate"]'
"""Program names in the example's project."""
_DRAWINGS_FOLDER: Final = "drawings"
"""Folder of drawings that are copied into a project."""
REPOSITORY_FILES: Final[Mapping[str, str]] = {
    ".gitignore": "gitignore",
    ".pre-commit-config.yaml": "pre-commit-config.yaml",
    ".github/workflows/robot.yml": "github.yml",
    ".gitlab-ci.yml": "gitlab-ci.yml",
}
"""Files that a repository needs; each is written unless it exists."""
_IGNORED_FOLDERS: Final = "/build/ and .robot-assistant/"
_VERSION_MARK: Final = "{{ version }}"
_NAMES_WIDTH: Final = 22
"""Columns before the comment behind the names."""
_LONGEST_NAME: Final = 60
_KINDS_LISTED: Final = 6
"""Kinds of entities that are listed of a drawing without work."""


@dataclass(frozen=True, slots=True)
class StartedProject:
    """Result of starting a project.

    written: files written, in their order. findings: files that existed already, and contents of
    drawings. blank: process files with values to fill in.
    """

    folder: FilePath
    written: tuple[FilePath, ...]
    findings: tuple[Diagnostic, ...] = ()
    blank: tuple[FilePath, ...] = ()


def start_project(
    folder: FilePath,
    drawings: Sequence[FilePath] = (),
    unit: str | None = None,
    values: FirstValues | None = None,
) -> StartedProject:
    """Writes what is missing of a project into a folder; overwrites nothing.

    drawings: programs of the project, each with a process file to be filled in; without any a new
    project has an example. One that is not in the folder is copied. unit: that they are in,
    whatever they say. values: of robot, language, tool and place; None for the example's robot and
    blanks. Raises Unreadable or Refused for drawings that cannot be used, Refused
    (exit status 2) if a file cannot be written.
    """
    drawn = [_add_drawing(folder, drawing, unit, values) for drawing in dict.fromkeys(drawings)]
    contents = {name: _template_bytes(template) for name, template in REPOSITORY_FILES.items()}
    contents[SCHEMA_FILE] = schema_text().encode()
    found = [finding for one in drawn for finding in one.findings]
    of_drawings = {name: data for one in drawn for name, data in one.files.items()}
    programs = _program_names([one.source for one in drawn])
    if has_project(folder):
        found += _missing_entries(folder, programs)
        contents = {**of_drawings, **contents}
    elif drawn:
        contents = {
            **of_drawings,
            PROJECT_FILE: _project_text(folder, _program_text(programs, values), programs, values),
            **contents,
        }
    else:
        example = {name: _template_bytes(template) for name, template in _EXAMPLE_DRAWING.items()}
        contents = {**example, PROJECT_FILE: _template_bytes(PROJECT_FILE), **contents}
    wanted: dict[FilePath, bytes] = {}
    for name, data in contents.items():
        file = folder / name
        if file.exists() or file.is_symlink():
            if _differs_on_disk(file, data):
                found.append(rules.KEPT(file=name, cure=_replacement_cure(name)))
            continue
        _refuse_link_folders(folder, file)
        wanted[file] = data
    blank = tuple(
        file for file in wanted if file.name.endswith(PROCESS_SUFFIX) and drawn and values is None
    )
    found += () if values is None else values.findings
    return StartedProject(folder, write_all(wanted), tuple(found), blank)


@dataclass(frozen=True, slots=True)
class _AddedDrawing:
    """source: from the folder. files: of the project that it needs, by name."""

    source: str
    files: Mapping[str, bytes]
    findings: tuple[Diagnostic, ...]


def survey_of(drawing: FilePath, unit: str | None) -> Survey:
    """What a drawing holds, in a unit whatever it says. Raises Unreadable or Refused."""
    chosen = NO_PROCESS if unit is None else replace(NO_PROCESS, unit=known_unit(unit))
    return survey(drawing, chosen, "as was stated")


def _add_drawing(
    folder: FilePath, drawing: FilePath, unit: str | None, values: FirstValues | None
) -> _AddedDrawing:
    """A drawing of the project, with its process file. Raises Unreadable or Refused."""
    found = survey_of(drawing, unit)
    files: dict[str, bytes] = {}
    here = drawing.resolve()
    if here.is_relative_to(folder.resolve()):
        source = here.relative_to(folder.resolve()).as_posix()
    else:
        source = f"{_DRAWINGS_FOLDER}/{drawing.name}"
        data = read_bytes(drawing)
        if (folder / source).exists() and _differs_on_disk(folder / source, data):
            raise Refused(rules.OTHER_DRAWING(path=str(drawing), file=source), exit_status=2)
        files[source] = data
    process = FilePath(source).with_suffix(PROCESS_SUFFIX).as_posix()
    files[process] = process_text(drawing.name, found, values).encode("utf-8", "replace")
    told = [finding for finding in found.findings if finding.severity is not Severity.INFO]
    if not (folder / process).exists():
        if found.missing:
            told = [finding for finding in told if finding.code != NO_BLOCK.code]
        told += _told_contents(found, process)
    return _AddedDrawing(source, files, tuple(f.within(str(drawing)) for f in told))


def _told_contents(survey: Survey, file: str) -> Iterator[Diagnostic]:
    """Findings about what a new process file leaves out, and about a drawing without work."""
    if survey.missing:
        names = [f"`{shown(name)}`" for name in survey.missing]
        yield rules.BLOCKS_MISSING(file=file, names=", ".join(names))
    rows = list(_drafting_names(survey.layers))
    if rows:
        rule = rules.NOT_WORK if survey.has_work else rules.NOTHING_ELSE
        yield rule(file=file, what=", ".join(rows))
    elif not survey.has_work:
        kinds: Counter[str] = Counter()
        for layer in survey.layers:
            kinds.update(layer.kinds)
        held = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common(_KINDS_LISTED))
        yield rules.NOTHING_DRAWN(held=held or "nothing")


def _program_names(sources: Sequence[str]) -> dict[str, str]:
    """Names of programs → their sources."""
    taken = TakenNames(())
    names: dict[str, str] = {}
    for source in sources:
        name = identifier(FilePath(source).stem, taken)[:_LONGEST_NAME]
        taken.add(name)
        names[name] = source
    return names


def _project_text(
    folder: FilePath, programs: str, names: Iterable[str], values: FirstValues | None
) -> bytes:
    """Return the example's project file, with these programs instead of the example's.

    Raises Refused (exit status 2) for a robot file that is not in the folder.
    """
    listed = toml_value(list(names))
    text = _template_bytes(PROJECT_FILE).decode().replace(_EXAMPLE_PROGRAM, programs)
    text = text.replace(f"{_EXAMPLE_NAMES:{_NAMES_WIDTH}}", f"{listed:{_NAMES_WIDTH}}")
    if values is None:
        return text.encode()
    return _with_controller(text, values.address, robot_text(values.robot_name, folder)).encode()


def _with_controller(text: str, address: str, robot: str) -> str:
    """Return a project file whose virtual controller moves this robot."""
    same = f'address = "{address}" ' in text
    lines = []
    for line in ended_lines(text):
        key = line.partition(" ")[0]
        if key in (_OF_EXAMPLE_CONTROLLER if not same else ()):
            continue
        stated = {"address": address, "robot": robot}
        if key in stated:
            row, _, about = line.partition(" # ")
            row = f"{key} = {toml_value(stated[key])}"
            about = about if same or key != "address" else about.partition(";")[0]
            line = f"{row:{COMMENT_COLUMN + 3}} # {about.removesuffix(chr(10))}\n"
        lines.append(line)
    return "".join(lines)


_OF_EXAMPLE_CONTROLLER: Final = ("task", "load")
"""Keys of a target that controllers of other languages do not have."""


def _missing_entries(folder: FilePath, programs: Mapping[str, str]) -> Iterator[Diagnostic]:
    """Yield findings for drawings that an existing project does not list. Raises Unreadable or
    Refused.
    """
    known = {recipe.source.resolve() for recipe in project_of(folder).programs.values()}
    for name, source in programs.items():
        if (folder / source).resolve() not in known:
            table = f"[programs.{name}] with source = {toml_value(source)}"
            yield rules.NOT_ADDED(name=name, source=source, table=table)


def has_project(folder: FilePath) -> bool:
    """True if the folder itself has a file with a project table; raise Unreadable."""
    file = folder / PROJECT_FILE
    python = folder / "pyproject.toml"
    of_python = python.is_file() and read_project(python, ("tool", "robot-assistant")) is not None
    return file.exists() or file.is_symlink() or of_python


def _refuse_link_folders(folder: FilePath, file: FilePath) -> None:
    """Raises Refused if a link on the way leads out of the folder."""
    if not file.parent.resolve().is_relative_to(folder.resolve()):
        raise Refused(rules.OUTSIDE(file=file), exit_status=2)


def _differs_on_disk(file: FilePath, data: bytes) -> bool:
    try:
        return read_file(file).replace(b"\r\n", b"\n") != data
    except OSError:
        return True


def _replacement_cure(name: str) -> str:
    if name == ".gitignore":
        return f"see that it ignores {_IGNORED_FOLDERS}"
    return "move it away and run `robot-assistant init` again to have a new one"


def _template_bytes(template: str) -> bytes:
    text = resource("templates", f"project/{template}").read_text(encoding="utf-8")
    return text.replace(_VERSION_MARK, __version__).encode()

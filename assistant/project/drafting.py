"""The process file that `init` writes for a drawing: its layers, and what only people know blank.

What would move a robot wrongly if it were guessed, the tip of the tool and the place of the work,
is left empty: until somebody fills it in, every command says so and writes nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from assistant.base.length_units import UNITS
from assistant.program.settings_tables import shown
from assistant.sources.drawing.survey import Extents, Survey, SurveyedLayer

COMMENT_COLUMN: Final = 30
"""Columns before a comment."""
BLANK_KEYS: Final = ("`tip` of [tools.tool]", "`position` of [frames.work]")
"""What has to be filled in before anything moves."""

TOP_ROWS: Final = (
    ("# home = [0, 0, 0, 0, 30, 0]", "of the axes: there the program begins and ends, with"),
    ('# robot = "irb1200-7-0.7"', "whose axes these are"),
    ("# joint_percent = 20", "of joint moves, for controllers that take no mm/s"),
)
MOTION_ROWS: Final = (
    ("speed = 100", "mm/s, where a layer or a location says no other"),
    ('tool = "tool"', "defined below"),
    ('frame = "work"', "defined below; base is the robot's own"),
    ("# blend = 1", 'mm of rounding at corners, or "fine"; without it within the tolerance'),
    ("# approach = 50", "mm in a line to locations, along the tool"),
    ("# retract = 50", "and away from them"),
    ('# kind = "joint"', "moves to locations; linear without it"),
)
TOOL_ROWS: Final = (
    ("tip = []", "mm: x, y, z of the tool centre point in the flange frame"),
    ("euler_zyx = [0, 0, 0]", "degrees about z, y, x that the tool is turned in the flange"),
    ("# mass = 1.2", "kg; with it also the next"),
    ("# centre = [0, 0, 60]", "mm, of gravity"),
    ("# free_turn = true", "a round tool, which may be turned about its axis"),
)
PLACEMENT_ROWS: Final = (
    ("# [placement]", "where the drawing stands in that frame, if not at its origin"),
    ("# position = [0, 0, 0]", "mm; or three marks, as drawn and as taught, instead:"),
    ("# euler_zyx = [0, 0, 0]", "degrees about z, y, x"),
    ("# drawing = [[0, 0], [100, 0], [0, 50]]", ""),
    ("# cell = [[0, 0, 0], [100, 0, 0], [0, 50, 0]]", ""),
)
SIGNAL_ROWS: Final = (
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
"""Keys of a layer that are told once."""

KeyRow = tuple[str, str]


def process_text(name: str, survey: Survey) -> str:
    """The process file of a drawing by its name."""
    return "\n".join(_process_lines(name, survey)) + "\n"


def _process_lines(name: str, survey: Survey) -> Iterator[str]:
    works = [layer for layer in survey.layers if layer.works]
    idle = [layer for layer in survey.layers if layer.kinds and not _is_worked(layer)]
    yield f"# How {shown(name, 80)} is worked: lengths in mm, speeds in mm/s, times in seconds,"
    yield "# angles in degrees, masses in kg. A line with a # before its key is a choice: take the"
    yield "# mark away to have it. Empty brackets have to be filled in before anything moves."
    yield ""
    yield from _commented_rows(
        [*_unit_rows(survey), ("tolerance = 0.05", "for joining ends, fitting curves")]
    )
    yield from _commented_rows([_left_out_row(idle)])
    yield from _commented_rows(TOP_ROWS)
    yield ""
    yield "[motion]"
    yield from _commented_rows(MOTION_ROWS)
    yield ""
    yield "[tools.tool]"
    yield from _commented_rows(TOOL_ROWS)
    yield ""
    yield from _commented_rows(
        [("[frames.work]", "where the drawing's origin stands, in the robot's base")]
    )
    yield from _commented_rows([("position = []", f"mm; {_extent_text(survey.extents)}")])
    yield from _commented_rows([("euler_zyx = [0, 0, 0]", "degrees about z, y, x")])
    for rows in (PLACEMENT_ROWS, SIGNAL_ROWS):
        yield ""
        yield from _commented_rows(rows)
    for number, layer in enumerate(works):
        yield ""
        yield f"[layers.{toml_quoted(layer.name)}]"
        yield f"# {_layer_content(layer)}"
        yield from _commented_rows(LAYER_ROWS)
        yield from _commented_rows(CHOICE_KEYS if not number else ())


def _is_worked(layer: SurveyedLayer) -> bool:
    return layer.works or layer.locations > 0


def _unit_rows(survey: Survey) -> Iterator[KeyRow]:
    short = next((key for key, (name, _) in UNITS.items() if name == survey.unit), None)
    if short is None:
        yield f"# the drawing is in {survey.unit}", "which it says itself"
    else:
        size = "" if survey.extents is None else f": it is {_size_text(survey.extents)} mm then"
        yield f"unit = {toml_quoted(short)}", f"{survey.stated}{size}"


def _left_out_row(idle: Sequence[SurveyedLayer]) -> KeyRow:
    names = ", ".join(toml_quoted(layer.name) for layer in idle)
    about = "nothing there can be followed" if idle else '["*"]: all that have no table here'
    return f"leave_out = [{names}]", about


def _layer_content(layer: SurveyedLayer) -> str:
    """What is on a layer, for a comment."""
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


def _commented_rows(rows: Sequence[KeyRow]) -> Iterator[str]:
    for key, about in rows:
        yield f"{key:{COMMENT_COLUMN - 1}} # {about}" if about else key


def toml_quoted(text: str) -> str:
    """A text as TOML has it, all of it in one line."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def program_text(sources: Mapping[str, str]) -> str:
    """Tables of programs, by their names, of sources as paths from the project's folder."""
    tables = [
        f"[programs.{name}]\nsource = {toml_quoted(path)}\n" for name, path in sources.items()
    ]
    return "\n".join(tables)

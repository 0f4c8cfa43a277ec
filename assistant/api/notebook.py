"""Notebook pages: programs, findings, compilations, simulations, robots, paths and recordings.

Everything from a program is escaped. A page holds at most `_MOST_FINDINGS` findings and
`_MOST_LINES` lines; the rest is counted.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.columns import columns_html, html_text
from assistant.base.diagnostics import Diagnostic, Refused, Severity, notes_last
from assistant.base.source_text import lines_of, visible
from assistant.compiler.arms import known_robot
from assistant.program.expressions import JointValue, Name
from assistant.program.geometry import Tool
from assistant.program.motion import Kind
from assistant.program.program import Program
from assistant.program.statements import MoveJoints
from assistant.report.figures import new_figure
from assistant.report.track import track

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from assistant.api.analysis import Check, Simulated
    from assistant.compiler import Compiled, Translation
    from assistant.program.motion import Path
    from assistant.robots import Robot
    from assistant.robots.timing.simulation import Samples


_WIDTH: Final = 300.0
_HEIGHT: Final = 220.0
_MARGIN: Final = 10.0
"""px of one view of a picture, and what is left free at its edges."""
_MOST_POINTS: Final = 2000
"""Points of a way that are drawn; of more, every second, third …"""
_MOST_FINDINGS: Final = 50
_MOST_LINES: Final = 200
"""Findings, and lines of a file, that are shown; the rest is counted."""
_COLOURS: Final = {Severity.ERROR: "#b3261e", Severity.WARNING: "#8a5a00", Severity.INFO: "#1f5f8b"}
_VIEWS: Final = (("from above", 0, 1), ("from the side", 0, 2))
"""Views of a picture, with the axes that lead to the right and up."""
_JOINT_INK: Final = "#9a9a9a"
_WORK_INK: Final = "#1f5f8b"


def program_html(program: Program) -> str:
    """A program: how long it is, and the way of its tool."""
    return f"<div><p>{_cut_text(repr(program)[1:-1])}</p>{_path_picture(program)}</div>"


def finding_html(finding: Diagnostic) -> str:
    return _findings_html([finding])


def _findings_html(findings: Sequence[Diagnostic]) -> str:
    """A table of findings, and how many more there are."""
    if not findings:
        return "<p>no findings</p>"
    lines = [_finding_row(finding) for finding in notes_last(findings)[:_MOST_FINDINGS]]
    more = len(findings) - len(lines)
    rest = f"<p>and {more} more</p>" if more > 0 else ""
    return f"<table><tbody>{''.join(lines)}</tbody></table>{rest}"


def check_html(check: Check) -> str:
    return f"<div><p>{_cut_text(repr(check)[1:-1])}</p>{_findings_html(check.findings)}</div>"


def compiled_html(compiled: Compiled) -> str:
    """Return a compiled program as a page: its proof, the tool path, findings and the text of the
    files.
    """
    told = [repr(compiled)[1:-1], *compiled.proof_lines()]
    parts = [_path_picture(compiled.source), _findings_html(compiled.findings)]
    return _html_page(told, parts, compiled.files.items())


def translation_html(translation: Translation) -> str:
    """Return a translation as a page: how much is translated, the tool path, findings and the
    files.
    """
    totals = ", ".join(f"{count} {level}" for level, count in translation.totals.items() if count)
    told = [repr(translation)[1:-1], totals]
    source = translation.compiled.source
    return _html_page(
        told,
        [_path_picture(source), _findings_html(translation.findings)],
        translation.files.items(),
    )


def simulated_html(done: Simulated) -> str:
    """A simulation: its times, and findings."""
    told = [repr(done)[1:-1]]
    told += [
        f"{name}: {time.most:.2f} s a call" for name, time in done.simulation.procedures.items()
    ]
    return _html_page(told, [_findings_html(done.findings)], ())


def _html_page(
    told: Iterable[str], parts: Iterable[str], files: Iterable[tuple[str, bytes]]
) -> str:
    lines = "".join(f"<p>{_cut_text(line)}</p>" for line in told)
    return f"<div>{lines}{''.join(parts)}{''.join(_file_html(*one) for one in files)}</div>"


def _file_html(name: str, data: bytes) -> str:
    lines = lines_of(data.decode("utf-8", "replace"))
    shown = "\n".join(_cut_text(line.expandtabs(4)) for line in lines[:_MOST_LINES])
    more = len(lines) - _MOST_LINES
    rest = f"\n… {more} more lines" if more > 0 else ""
    return f"<details><summary>{_cut_text(name)}</summary><pre>{shown}{rest}</pre></details>"


def _finding_row(finding: Diagnostic) -> str:
    colour = _COLOURS[finding.severity]
    cure = f"<br><small>{_cut_text(finding.cure)}</small>" if finding.cure else ""
    head = f'<td style="color:{colour}">{_cut_text(finding.code)} {finding.severity}</td>'
    where = f"<td>{_cut_text(finding.where())}</td>"
    return f"<tr>{head}{where}<td>{_cut_text(finding.message)}{cure}</td></tr>"


def _cut_text(text: str) -> str:
    return escape(visible(text))


def _path_picture(program: Program) -> str:
    """The way of the tool from above and from the side; nothing of one that does not move."""
    points, joint = _tool_path(program)
    if len(points) < 2:
        return ""
    every = -(-len(points) // _MOST_POINTS)
    kept = np.unique(np.append(np.arange(0, len(points), every), len(points) - 1))
    points, joint = points[kept], joint[kept]
    low, high = points.min(axis=0), points.max(axis=0)
    extents = ", ".join(f"{axis} {low[i]:.1f} to {high[i]:.1f} mm" for i, axis in enumerate("xyz"))
    views = "".join(
        _path_view(label, points[:, [x, y]], joint, number * _WIDTH)
        for number, (label, x, y) in enumerate(_VIEWS)
    )
    size = f'width="{2 * _WIDTH:.0f}" height="{_HEIGHT:.0f}"'
    box = f'viewBox="0 0 {2 * _WIDTH:.0f} {_HEIGHT:.0f}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} {box} fill="none" '
        f'style="background:white">{views}</svg><p><small>{extents}; '
        "grey: joint moves, which the arm does not make in a line</small></p>"
    )


def _path_view(label: str, points: Floats, joint: Floats, left: float) -> str:
    """Points (n, 2) mm, scaled alike along both axes into one view, y upwards. left: its edge."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.array([_WIDTH, _HEIGHT]) - 2 * _MARGIN
    span = high - low
    scale = float(np.min(room / np.maximum(span, 1e-9))) if span.max() > 1e-9 else 1.0
    middle = np.array([left + _WIDTH / 2, _HEIGHT / 2])
    places = (points - (low + high) / 2) * scale * [1.0, -1.0] + middle
    lines = [
        f'<polyline points="{one}" stroke="{_JOINT_INK if grey else _WORK_INK}" '
        'stroke-width="1.2"/>'
        for one, grey in _motion_stretches(places, joint)
    ]
    x, y = places[0]
    start = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{_WORK_INK}"/>'
    text = f'<text x="{left + _MARGIN:.0f}" y="14" fill="#555" font-size="11">{label}</text>'
    return f"{''.join(lines)}{start}{text}"


def _motion_stretches(places: Floats, joint: Floats) -> Iterable[tuple[str, bool]]:
    """Point lists of moves of one kind that follow each other, and whether they are joint moves."""
    cuts = np.flatnonzero(np.diff(joint[1:].astype(np.int8))) + 1
    begins, ends = np.append(0, cuts), np.append(cuts, len(places) - 1)
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        some = places[begin : end + 1]
        yield " ".join(f"{x:.1f},{y:.1f}" for x, y in some), bool(joint[begin + 1])


def _tool_path(program: Program) -> tuple[Floats, Floats]:
    """Points (n, 3) mm in the robot's base, and whether a joint move leads to each."""
    drawn = track(program)
    if len(drawn):
        return drawn.positions, drawn.kinds == Kind.JOINT
    rows = list(_program_joints(program))
    try:
        arm = known_robot(program.robot)
    except Refused:  # an arm of the user's own
        arm = None
    own = [] if arm is None else [arm.own_joints(row) for row, _ in rows]
    if arm is None or not own or any(len(row) != len(arm.axes) for row in own):
        return np.empty((0, 3)), np.empty(0, dtype=bool)
    positions, quaternions = arm.flange_poses(own)
    tools = [program.tools.get(name, Tool()) for _, name in rows]
    tips = np.array([tool.tip.position if tool.held else (0.0, 0.0, 0.0) for tool in tools])
    return positions + rotations.rotate(quaternions, tips), np.ones(len(own), dtype=bool)


def _program_joints(program: Program) -> Iterable[tuple[Sequence[float], str]]:
    """The joints that the moves of a program go to, in order of text, each with its tool."""
    for statement in program.statements():
        if isinstance(statement, MoveJoints):
            target = statement.target
            if isinstance(target, JointValue):
                yield target.target.joints, statement.motion.tool
            elif isinstance(target, Name) and target.name in program.joint_targets:
                yield program.joint_targets[target.name].joints, statement.motion.tool


_ARM_SIZE: Final = 260.0
"""px of the picture of an arm."""


class RecordedColumns(Protocol):
    """A recording of a controller: labels of its columns, and its rows (n, k)."""

    @property
    def labels(self) -> tuple[str, ...]: ...

    def rows(self) -> Floats: ...


def robot_html(robot: Robot) -> str:
    """An arm: its limits and speeds, and how it stands at home, seen from the side."""
    told = [f"{robot.title}, {robot.maker}", f"arm {robot.arm.kind}, reach {robot.reach:.0f} mm"]
    if robot.payload is not None:
        told.append(f"payload {robot.payload:g} kg")
    told.append(f"languages {', '.join(robot.languages)}")
    head = "".join(f"<th>{one}</th>" for one in ("", "from", "to", "home", "speed a second", "in"))
    rows = "".join(
        f"<tr><td>{html_text(name)}</td><td>{low:g}</td><td>{high:g}</td><td>{home:g}</td>"
        f"<td>{speed:g}</td><td>{unit}</td></tr>"
        for name, (low, high), home, speed, unit in zip(
            *(robot.axes, robot.limits, robot.home, robot.speeds, robot.units), strict=True
        )
    )
    lines = "".join(f"<p>{html_text(line)}</p>" for line in told)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return f"<div><b>{html_text(robot.name)}</b>{lines}{table}{_links_at_home(robot)}</div>"


def arm_figure(robot: Robot, joints: Floats) -> Figure:
    """Draw the links of an arm at joints (n, a) and the axes of its flange, in mm."""
    figure = new_figure(6.0, 6.0)
    space: Any = figure.add_subplot(projection="3d")
    chains = robot.chain(joints)
    for number, points in enumerate(chains, 1):
        part = 1.0 if number == len(chains) else 0.25
        space.plot(*points.T, color="C0", alpha=part, linewidth=5, marker="o", markersize=7)
    positions, quaternions = robot.flange_poses(joints)
    length = 0.15 * robot.reach
    for axis, colour in zip(np.eye(3), ("C3", "C2", "C0"), strict=True):
        ends = positions + length * rotations.rotate(quaternions, np.tile(axis, (len(joints), 1)))
        for start, end in zip(positions, ends, strict=True):
            space.plot(*np.stack([start, end]).T, color=colour, linewidth=1.5)
    every = np.concatenate([chains.reshape(-1, 3), np.zeros((1, 3))])
    middle = (every.min(axis=0) + every.max(axis=0)) / 2.0
    half = max(float(np.ptp(every, axis=0).max()) / 2.0, length) * 1.1
    space.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    space.set(zlim=(middle[2] - half, middle[2] + half))
    space.set(xlabel="x, mm", ylabel="y, mm", zlabel="z, mm", title=robot.title)
    space.set_box_aspect((1.0, 1.0, 1.0))
    return figure


def path_html(path: Path) -> str:
    """A path: how each row is reached, and where it is."""
    kinds = np.array([Kind(kind).name.lower() for kind in path.kinds])
    places = dict(zip(("x", "y", "z"), path.positions.T, strict=True))
    turns = dict(zip(("qw", "qx", "qy", "qz"), path.quaternions.T, strict=True))
    return columns_html(repr(path)[1:-1], {"by": kinds} | places | turns)


def samples_html(samples: Samples) -> str:
    """The motion of a simulation."""
    places = dict(zip(("x", "y", "z"), samples.position.T, strict=True))
    told = repr(samples)[1:-1]
    return columns_html(
        told, {"s": samples.t, "joint": samples.joints} | places | {"mm/s": samples.tcp_speed}
    )


def recording_html(recording: RecordedColumns) -> str:
    return columns_html(
        repr(recording)[1:-1], dict(zip(recording.labels, recording.rows().T, strict=True))
    )


def _links_at_home(robot: Robot) -> str:
    """Draw the links at home as a line, in the vertical plane of the arm."""
    points = robot.chain(robot.home[None])[0]
    out = np.hypot(points[-1, 0], points[-1, 1])
    way = points[-1, :2] / out if out > 1.0 else np.array([1.0, 0.0])
    flat = np.column_stack([points[:, :2] @ way, points[:, 2]])
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = (_ARM_SIZE - 40.0) / max(float((high - low).max()), 1e-9)
    places = (flat - (low + high) / 2.0) * scale * [1.0, -1.0] + _ARM_SIZE / 2.0
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4"/>' for x, y in places)
    x, y, z = robot.flange_poses(robot.home)[0][0]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_ARM_SIZE:.0f}" height="{_ARM_SIZE:.0f}" '
        f'viewBox="0 0 {_ARM_SIZE:.0f} {_ARM_SIZE:.0f}" style="background:white" fill="#1f5f8b">'
        f'<polyline points="{line}" fill="none" stroke="#1f5f8b" stroke-width="5" '
        f'stroke-linecap="round" stroke-linejoin="round"/>{dots}</svg>'
        f"<p><small>at home, from the side; flange at {x:.1f}, {y:.1f}, {z:.1f} mm</small></p>"
    )

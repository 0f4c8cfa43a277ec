"""What `reach base` and `reach place` do."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors, info
from assistant.cli.compiling import working
from assistant.cli.presentation import Format, print_findings, say
from assistant.cli.reach_runs import (
    PlacedArm,
    ReachTool,
    output_files,
    placed_arm,
    print_reach,
    write_reach,
)

if TYPE_CHECKING:
    from assistant.cell import placement
    from assistant.cell.placement import Places

NO_CELL = error(
    "CL040", "where `{name}` stands is not said", "name the cell file that has it with --cell"
)
TIP_TWICE = error(
    "CL041", "the program says the tips of its tools", "leave --tip out, or the program"
)
UNKNOWN_TARGETS = info(
    "CL042",
    "{count} moves go to what only running the program tells; they are left out",
    "nothing; look at these places by themselves",
)
DEFAULT_PLACE_RANGE: Final = "-200:200:50"
"""Of x and y if nothing is stated."""


@dataclass(frozen=True, slots=True)
class PlaceGoals:
    """The program whose targets are to be reached, None for locations, and how it is read."""

    program: str | None
    process: Path | None
    unit: str | None
    from_language: str | None


def run_places(
    body: str | None,
    tool: ReachTool,
    goals: PlaceGoals,
    ranges: Mapping[str, str | None],
    outputs: Sequence[str],
    format: Format,
) -> int:
    """1 if everything is reached at no place, else 0. body: None for the base of the robot."""
    from assistant.cell import placement
    from assistant.cell.findings import NO_PLACE
    from assistant.cell.reach_map import grid, parse_range
    from assistant.report import places as report

    files = output_files(outputs, PLACE_WRITERS)
    offsets = grid([parse_range(text, axis) for axis, text in _place_ranges(ranges).items()])
    if body is not None and tool.cell is None:
        raise Refused(NO_CELL(name=body), exit_status=2)
    with working("looking at places"):
        there, targets, findings = _place_targets(body, tool, goals)
        given = there.scene, there.placed
        if body is None:
            name, of = there.placed.name, "robots"
            found = placement.best_base(
                *given, offsets, targets, bodies=there.bodies, margin=tool.margin
            )
        else:
            name, of = body, "bodies"
            found = placement.best_place(*given, body, offsets, targets, margin=tool.margin)
        title = f"{name}, for {there.placed.robot.title}"
        sources = () if goals.program is None else (goals.program,)
        drawn = {
            path: PLACE_WRITERS[path.suffix.lower()](found, title) for path in files if found.places
        }
        written = write_reach(tool, drawn, *sources)
    findings += found.findings
    if found.best is None and found.places:
        first = found.places[0]
        findings.append(
            NO_PLACE(
                count=len(offsets),
                best=report.place_text(first),
                reached=first.reached,
                total=found.total,
                first=first.worst,
            )
        )
    status = 1 if has_errors(findings) or found.best is None else 0
    if format is Format.JSON:
        answer = {"robot": there.placed.robot.name, "moved": name, **report.places_record(found)}
        print_reach(answer, findings, written)
        return status
    print_findings(findings, explained=True)
    say(f"{title}; places: {len(offsets):,}; targets: {found.total:,}")
    say("")
    for line in report.place_lines(found):
        say(line)
    if found.best is not None and there.bodies:
        say("")
        say(f"[{of}.{name}]")
        for line in report.pose_text(found.best.pose):
            say(line)
    for path in written:
        say(f"wrote {path}")
    return status


def _place_ranges(ranges: Mapping[str, str | None]) -> dict[str, str]:
    stated = {axis: text for axis, text in ranges.items() if text is not None}
    return dict.fromkeys(ranges, "0") | (
        stated or {"x": DEFAULT_PLACE_RANGE, "y": DEFAULT_PLACE_RANGE}
    )


def _place_targets(
    body: str | None, tool: ReachTool, goals: PlaceGoals
) -> tuple[PlacedArm, Sequence[placement.Goals], list[Diagnostic]]:
    from assistant.cell.placement import locations, standing_body
    from assistant.cell.reach_map import check_turns

    check_turns(tool.turns)
    if goals.program is not None:
        return _program_targets(body, tool, goals, goals.program)
    there = placed_arm(tool)
    if body is not None:
        standing_body(there.scene, body)
    targets = locations(there.scene, body, there.tip, tool.turns)
    return there, (targets,), list(there.findings)


def _program_targets(
    body: str | None, tool: ReachTool, goals: PlaceGoals, program: str
) -> tuple[PlacedArm, Sequence[placement.Goals], list[Diagnostic]]:
    """What its arm cannot reach now is no finding here."""
    from assistant.cell.placement import targets_of
    from assistant.cli.simulating import SimulationOptions, solved_source

    if tool.tip is not None:
        raise Refused(TIP_TWICE(), exit_status=2)
    given = (goals.process, goals.unit, goals.from_language, None)
    ready = solved_source(
        program, SimulationOptions(tool.robot, *given, None, None, cell=tool.cell)
    )
    solution = ready.solution
    there = placed_arm(tool, solution.robot)
    found = targets_of(solution, there.placed, tool.turns, carried=body is None)
    findings = list(there.findings)
    if found.unknown:
        findings.append(UNKNOWN_TARGETS(count=found.unknown))
    return there, found.goals, findings


def _places_csv(found: Places, title: str) -> bytes:  # noqa: ARG001 (each writer is given both)
    from assistant.report.places import places_csv

    return places_csv(found)


def _places_picture(format: str) -> Callable[[Places, str], bytes]:
    def draw(found: Places, title: str) -> bytes:
        from assistant.report.places import places_picture

        return places_picture(found, title, format)

    return draw


PLACE_WRITERS: Final[dict[str, Callable[[Places, str], bytes]]] = {
    ".csv": _places_csv,
    ".png": _places_picture("png"),
    ".svg": _places_picture("svg"),
}

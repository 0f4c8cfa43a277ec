"""`explore`: charts of the space that a robot has been in, made larger, joined and compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Refused, error, has_errors
from assistant.cli.compiling import keep_sources, working
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.cell.exploration.occupancy import Occupancy
    from assistant.cli.simulating import SimulationOptions
    from assistant.compiler.exploration import (
        ExplorationRequest,
        ExplorationResult,
        ExplorationStart,
    )

NO_CHART_NAME: Final = error("CL280", "a chart is not written as `{name}`", "end its name in .npz")
NO_UNTIL: Final = error("CL281", "--until is {value:g}", "write seconds above 0")
ONLY_MOVED: Final = error(
    "CL288",
    "{what}, and --cell is missing",
    "name the controller, and add --cell with the file of its cell",
)
ONLY_STILL: Final = error(
    "CL289",
    "`{option}` is for a cell in which nothing moves, and --cell moves an arm",
    "leave out one of them",
)
CHART_SUFFIX: Final = ".npz"


def check_still(where: str, given: Mapping[str, object]) -> None:
    """Raise Refused for what is only for an arm that moves: its options, or a controller."""
    left_out: tuple[object, ...] = (None, False, [])
    option = next((name for name, value in given.items() if value not in left_out), None)
    if option is not None:
        raise Refused(ONLY_MOVED(what=f"`{option}` is for an arm that moves"), exit_status=2)
    if not Path(where).suffix and not Path(where).exists():
        what = f"`{where}` is not a cell file but a controller"
        raise Refused(ONLY_MOVED(what=what), exit_status=2)


def check_moving(hidden: Path | None) -> None:
    """Raise Refused for an option of a cell in which nothing moves."""
    if hidden is not None:
        raise Refused(ONLY_STILL(option="--hidden"), exit_status=2)


def run_wander(
    asked: ExplorationRequest, hidden: Path | None, runs: int, seed: int | None, format: Format
) -> int:
    from assistant.compiler.exploration import explore_by_random_moves

    with working("exploring"):
        begun = prepare_chart(asked, [] if hidden is None else [str(hidden)])
        found = explore_by_random_moves(begun, hidden, runs, seed)
    return _report_exploration(begun, found, "runs", format)


def run_recorded(
    asked: ExplorationRequest, recordings: Sequence[Path], contact: str | None, format: Format
) -> int:
    from assistant.compiler.exploration import explore_by_recordings

    with working("reading what was recorded"):
        begun = prepare_chart(asked, [str(path) for path in recordings])
        found = explore_by_recordings(begun, recordings, contact)
    return _report_exploration(begun, found, "runs of each recording", format)


def run_program(
    asked: ExplorationRequest,
    source: str,
    options: SimulationOptions,
    until: float | None,
    hidden: Path | None,
    format: Format,
) -> int:
    """1 if the robot cannot run the program; then the chart stays as it is."""
    from assistant.cli.simulating import report_errors, solved_source
    from assistant.compiler.arms import InCell
    from assistant.compiler.exploration import explore_by_program
    from assistant.robots.timing import simulate

    if until is not None and not until > 0.0:
        raise Refused(NO_UNTIL(value=until), exit_status=2)
    with working(f"going through {source}"):
        begun = prepare_chart(asked, [source, *([] if hidden is None else [str(hidden)])])
        explorer = begun.explorer
        named = None if asked.robot is None else explorer.placed.robot
        scene = replace(explorer.scene, runs=asked.robot)
        done = solved_source(source, options, InCell(scene, named))
        if has_errors(done.findings):
            robot = done.solution.robot
            return report_errors(source, robot, done.findings, format, "gone through")
        simulation = simulate(done.solution, acceleration=options.acceleration)
        try:
            found = explore_by_program(begun, done.program, simulation, until, hidden)
        except Refused as caught:
            findings = [done.places.finding(one).within(source) for one in caught.findings]
            raise Refused(*findings, exit_status=caught.exit_status) from None
    return _report_exploration(begun, found, "runs", format)


def prepare_chart(asked: ExplorationRequest, read: Sequence[str]) -> ExplorationStart:
    """Raises Refused for a chart that would not be one, or would be written over what is read."""
    from assistant.compiler.exploration import start_exploration

    _check_chart_name(asked.chart)
    keep_sources([str(asked.cell), *read], [asked.chart])
    return start_exploration(asked)


def _check_chart_name(path: Path) -> None:
    if path.suffix.lower() != CHART_SUFFIX or not path.stem:
        raise Refused(NO_CHART_NAME(name=path), exit_status=2)


def _report_exploration(
    begun: ExplorationStart, found: ExplorationResult, what: str, format: Format
) -> int:
    from assistant.cell.exploration.occupancy import save_map

    save_map(found.occupancy, begun.asked.chart)
    return report_chart(ExplorationSummary(found, what, [begun.asked.chart]), format)


@dataclass(frozen=True, slots=True)
class ExplorationSummary:
    """Result of exploring. what: the runs that its rows count. written: files."""

    found: ExplorationResult
    what: str
    written: Sequence[Path]


def report_chart(done: ExplorationSummary, format: Format) -> int:
    """Print the result and the free space so far; returns the exit status."""
    from assistant.findings.formats import finding_record

    found, what = done.found, done.what
    if format is Format.JSON:
        rows = [dict(zip(("runs", "new", "litres"), row, strict=True)) for row in found.runs]
        findings = [finding_record(one) for one in found.findings]
        answer = {
            "explored": rows,
            "contacts": found.contacts,
            "chart": _chart_record(found.occupancy),
        }
        written = [str(path) for path in done.written]
        print_json(answer | {"findings": findings, "written": written})
        return 0
    print_findings(found.findings, explained=True)
    say(f"{what:>24} {'new cells':>12} {'litres free':>12}")
    for runs, new, litres in found.runs:
        say(f"{runs:>24,} {new:>12,} {litres:>12.1f}")
    say("")
    if found.contacts:
        where = f", {found.placeless} of them nobody knows where" if found.placeless else ""
        say(f"contacts: {found.contacts}{where}")
    for line in _chart_lines(found.occupancy):
        say(line)
    say(f"wrote {', '.join(str(path) for path in done.written)}")
    return 0


def _chart_record(occupancy: Occupancy) -> dict[str, Any]:
    from assistant.cell.exploration.occupancy import CellState

    counts = occupancy.counts()
    return {
        "robot": occupancy.robot,
        "cell_mm": occupancy.size,
        "runs": occupancy.runs,
        "free": counts[CellState.FREE],
        "occupied": counts[CellState.OCCUPIED],
        "litres": occupancy.litres,
        "box_mm": [low_high.tolist() for low_high in _free_box(occupancy)],
    }


def _free_box(occupancy: Occupancy) -> Sequence[Any]:
    """Lowest and highest corner (3,) of the free cells in mm of the base; none without any."""
    from assistant.cell.exploration.occupancy import CellState

    cells = occupancy.cells(CellState.FREE)
    if not len(cells):
        return ()
    return cells.min(axis=0) * occupancy.size, (cells.max(axis=0) + 1) * occupancy.size


def _chart_lines(occupancy: Occupancy) -> list[str]:
    record = _chart_record(occupancy)
    out = [
        f"robot    {record['robot']}",
        f"cells    {record['cell_mm']:g} mm",
        f"runs     {record['runs']:,}",
        f"free     {record['free']:,} cells, {record['litres']:.1f} l",
        f"occupied {record['occupied']:,} cells",
    ]
    if record["box_mm"]:
        low, high = ([f"{value:g}" for value in corner] for corner in record["box_mm"])
        out.append(f"between  ({', '.join(low)}) and ({', '.join(high)}) mm of the base")
    return out


def run_chart_shown(path: Path, output: Path | None, format: Format) -> int:
    """output: a picture of it that is written."""
    from assistant.base.file_sets import write_all
    from assistant.cell.exploration.occupancy import load_map
    from assistant.report.explored_space import explored_picture
    from assistant.report.figures import format_of

    kind = "" if output is None else format_of(output.name)
    occupancy = load_map(path)
    written: list[str] = []
    if output is not None:
        keep_sources([str(path)], [output])
        written = [str(one) for one in write_all({output: explored_picture(occupancy, kind)})]
    if format is Format.JSON:
        print_json({"chart": str(path), **_chart_record(occupancy), "written": written})
        return 0
    for line in [*_chart_lines(occupancy), *(f"wrote {one}" for one in written)]:
        say(line)
    return 0


def run_charts_merged(paths: Sequence[Path], output: Path, format: Format) -> int:
    from assistant.cell.exploration.occupancy import load_map, save_map

    _check_chart_name(output)
    keep_sources([str(path) for path in paths], [output])
    merged = load_map(paths[0])
    for path in paths[1:]:
        other = load_map(path)
        with _at_chart(path):
            merged = merged.merged(other)
    save_map(merged, output)
    if format is Format.JSON:
        print_json({"chart": _chart_record(merged), "written": [str(output)]})
        return 0
    for line in _chart_lines(merged):
        say(line)
    say(f"wrote {output}")
    return 0


def run_charts_compared(old: Path, new: Path, format: Format) -> int:
    """1 if what was free is not any more."""
    from assistant.cell.exploration.occupancy import load_map

    before, after = load_map(old), load_map(new)
    with _at_chart(new):
        found = before.compared(after)
    if format is Format.JSON:
        print_json({"old": str(old), "new": str(new), **asdict(found)})
    else:
        litre = before.size**3 / 1e6
        for count, what in (
            (found.same, "are known alike"),
            (found.gained, f"are known in {new} only"),
            (found.lost, f"are known in {old} only"),
            (found.freed, "were occupied and are free"),
            (found.blocked, "were free and are occupied"),
        ):
            say(f"{count:>12,} cells ({count * litre:.1f} l) {what}")
    return 1 if found.blocked else 0


@contextmanager
def _at_chart(path: Path) -> Iterator[None]:
    """What is refused of a chart is told at its file."""
    try:
        yield
    except Refused as refused:
        findings = [finding.within(str(path)) for finding in refused.findings]
        raise Refused(*findings, exit_status=refused.exit_status) from None

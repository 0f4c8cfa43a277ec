"""What `reach swept` does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import fold, has_errors
from assistant.cli.compiling import working
from assistant.cli.presentation import Format, print_findings, say
from assistant.cli.reach_runs import ReachTool, output_files, placed_arm, print_reach, write_reach
from assistant.cli.simulating import SimulationOptions, report_errors, solved_source

if TYPE_CHECKING:
    from assistant.cell.swept_space import SweptSpace


def run_swept(
    source: str, options: SimulationOptions, size: float, outputs: Sequence[str], format: Format
) -> int:
    """1 if the robot cannot run the program, else 0; contacts are for `check` to find."""
    from assistant.cell.clearances import CarriedBodies
    from assistant.cell.findings import NOT_SWEPT
    from assistant.cell.swept_space import swept_space
    from assistant.report import swept_space as report
    from assistant.robots.timing import simulate

    files = output_files(outputs, SWEPT_WRITERS)
    with working(f"sweeping with {source}"):
        ready = solved_source(source, options)
        solution = ready.solution
        if has_errors(ready.findings):
            return report_errors(source, solution.robot, ready.findings, format, "swept")
        tool = ReachTool(options.robot, options.cell)
        there = placed_arm(tool, solution.robot)
        holding = CarriedBodies.at_first(there.scene, there.placed)
        done = simulate(solution, carried=holding if holding.places else None)
        found = swept_space(done, there.scene, there.placed, size)
        title = f"{Path(source).name} on {solution.robot.title}, cells of {size:g} mm"
        drawn = {path: SWEPT_WRITERS[path.suffix.lower()](found, title) for path in files}
        written = write_reach(tool, drawn, source)
    findings = list(ready.findings)
    findings += [
        NOT_SWEPT(what=f"only running the program tells where `{name}` is after a while")
        for name in sorted(holding.doubts.lost)
    ]
    findings += [
        NOT_SWEPT(what=str(unknown)) for unknown in done.unknown if "not timed" in unknown.what
    ]
    findings = list(fold(findings))
    if format is Format.JSON:
        robot = solution.robot.name
        print_reach(
            {"source": source, "robot": robot, **report.swept_record(found)}, findings, written
        )
        return 0
    print_findings(findings, explained=True)
    say(title)
    say("")
    for line in report.swept_lines(found):
        say(line)
    for path in written:
        say(f"wrote {path}")
    return 0


def _swept_csv(found: SweptSpace, title: str) -> bytes:  # noqa: ARG001 (each writer is given both)
    from assistant.report.swept_space import swept_csv

    return swept_csv(found)


def _swept_npz(found: SweptSpace, title: str) -> bytes:  # noqa: ARG001
    from assistant.report.swept_space import swept_npz

    return swept_npz(found)


def _swept_glb(found: SweptSpace, title: str) -> bytes:  # noqa: ARG001
    from assistant.report.swept_space import swept_glb

    return swept_glb(found)


def _swept_picture(format: str) -> Callable[[SweptSpace, str], bytes]:
    def draw(found: SweptSpace, title: str) -> bytes:
        from assistant.report.swept_space import swept_picture

        return swept_picture(found, title, format)

    return draw


SWEPT_WRITERS: Final[dict[str, Callable[[SweptSpace, str], bytes]]] = {
    ".csv": _swept_csv,
    ".npz": _swept_npz,
    ".glb": _swept_glb,
    ".png": _swept_picture("png"),
    ".svg": _swept_picture("svg"),
}

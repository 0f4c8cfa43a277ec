"""`kinematics` and `fmu`: source and blocks that are written for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from assistant.cli.presentation import Format, print_findings, print_json, say


def run_kinematics(
    name: str, language: Literal["c", "python"], folder: Path, format: Format
) -> int:
    """0 when the source is written; raises Refused for an arm without a closed form."""
    from assistant.blocks.code import kinematics
    from assistant.compiler.arms import robot_of
    from assistant.program.system.writing import write_files

    robot = robot_of(name)
    assert robot is not None
    print_findings(robot.findings)
    written = write_files(kinematics(robot, language), folder)
    if format is Format.JSON:
        print_json({"robot": robot.name, "written": list(map(str, written))})
        return 0
    for path in written:
        say(f"wrote {path}")
    return 0

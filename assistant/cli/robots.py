"""`robots` and `robots show`: the catalogue, one robot of it or of the user's own, its drawing."""

from __future__ import annotations

from pathlib import Path

from assistant.cli.presentation import Format, print_findings, print_json, say


def list_robots(format: Format) -> int:
    from assistant import robots
    from assistant.report import robots as report

    known = [robots.get(name) for name in robots.names()]
    if format is Format.JSON:
        print_json([report.brief_record(robot) for robot in known])
        return 0
    for line in report.robot_table(known):
        say(line)
    return 0


def show_robot(name: str, draw: Path | None, format: Format) -> int:
    """draw: the picture that is written before anything is said; None for none."""
    from assistant.compiler.arms import robot_of
    from assistant.report import robots as report

    robot = robot_of(name)
    assert robot is not None
    print_findings(robot.findings)
    drawn = None
    if draw is not None:
        from assistant.base.file_sets import write_files
        from assistant.report.arm_drawing import arm_drawing
        from assistant.report.figures import format_of

        picture = arm_drawing(robot, format_of(draw.name))
        (drawn,) = write_files({draw.name: picture}, draw.parent)
    if format is Format.JSON:
        print_json(report.robot_record(robot) | ({} if drawn is None else {"drawing": str(drawn)}))
        return 0
    for line in report.robot_lines(robot):
        say(line)
    if drawn is not None:
        say(f"drawing: {drawn}")
    return 0

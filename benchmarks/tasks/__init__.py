"""Whole tasks of real cells in the other vendor's language: how many cross, and what stops them.

    python -m benchmarks --only tasks --corpus FOLDER [--to LANGUAGE] [--task PART-OF-NAME]
        [--proof SECONDS] [--robot R --from-robot R] [--alone] [--jobs N] [--limit SECONDS]
        [--details FILE]

FOLDER holds `rapid/<repository>/<path with __ for />` and `melfa/<repository>/…`.
"""

from __future__ import annotations

import argparse
from pathlib import Path


def arguments(group: argparse._ArgumentGroup) -> None:
    """What the command takes for tasks."""
    group.add_argument("--corpus", type=Path, help="folder of real programs")
    group.add_argument("--to", help="only into this language")
    group.add_argument("--task", default="", help="only tasks with this in their names")
    group.add_argument("--proof", type=float, default=10.0, help="seconds of a proof, 0 for none")
    group.add_argument("--robot", help="arm that will run them")
    group.add_argument("--from-robot", help="arm that they were for")
    group.add_argument("--alone", action="store_true", help="also RAPID modules by themselves")
    group.add_argument("--jobs", type=int, default=1, help="tasks at a time")
    group.add_argument("--limit", type=float, default=300.0, help="seconds of a task")
    group.add_argument("--details", type=Path, help="file for what is said of each task, as JSON")


def run(chosen: argparse.Namespace) -> None:
    """Translates and proves the tasks, and prints what becomes of them."""
    from benchmarks.tasks.report import Plan, report

    if chosen.corpus is None or not chosen.corpus.is_dir():
        raise SystemExit("name the folder of the programs: --corpus FOLDER")
    report(
        Plan(
            chosen.corpus,
            to=chosen.to,
            task=chosen.task,
            proof=chosen.proof,
            robot=chosen.robot,
            from_robot=chosen.from_robot,
            alone=chosen.alone,
            jobs=chosen.jobs,
            limit=chosen.limit,
            details=chosen.details,
        )
    )

"""Draws whole tasks and translates them: `python -m tests.fuzz.tasks --count 200 [--first 0]`.

Each failure is told by its number; `--show NUMBER` writes that task to a folder.
"""

from __future__ import annotations

import argparse
import traceback
from collections import Counter
from pathlib import Path

from tests.fuzz.target import Broken
from tests.fuzz.tasks.drawing import drawn
from tests.fuzz.tasks.passing import passes


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.tasks", description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="number of the first task")
    parser.add_argument("--seconds", type=float, default=3.0, help="of each proof by motion")
    parser.add_argument("--show", type=int, help="only write the files of this task")
    parser.add_argument("--folder", type=Path, default=Path(), help="where to write them")
    given = parser.parse_args()
    if given.show is not None:
        for name, text in drawn(f"task {given.show}").files.items():
            path = given.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return 0
    totals: Counter[str] = Counter()
    whole = failed = 0
    for number in range(given.first, given.first + given.count):
        try:
            passed = passes(f"task {number}", seconds=given.seconds)
        except Broken as broken:
            failed += 1
            print(f"task {number}: {broken}", flush=True)
        except Exception:
            failed += 1
            print(f"task {number}: {traceback.format_exc()}", flush=True)
        else:
            totals.update(passed.totals)
            whole += passed.whole
    said = ", ".join(f"{count} {level}" for level, count in totals.items())
    print(f"{given.count} tasks, {whole} whole and proven, {failed} failed; statements: {said}")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())

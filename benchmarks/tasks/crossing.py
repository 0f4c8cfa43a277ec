"""One task in another language, in a process of its own: what of it is said, as JSON."""

from __future__ import annotations

import json
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from assistant.compiler import Loaded, translate
from assistant.compiler.motion import Proving
from assistant.compiler.tasks import Task, load_task, tasks_of
from assistant.compiler.translating import Translation
from assistant.program.diagnostics import Diagnostic, Refused, Severity

NO_MAIN = "MB245"
"""What is said of a library that a program cannot begin with."""
SHOWN = 400
"""Characters of a reason that are told."""


def crossed(given: dict[str, Any]) -> dict[str, Any]:
    """What becomes of a task.

    given: files, language, begins, to, robot, from_robot, proof (seconds, 0 for none), cell.
    """
    began = time.perf_counter()
    out: dict[str, Any] = {"said": 0, "partly": 0, "not": 0, "whole": False, "proof": "not run"}
    try:
        out |= _crossed(given)
    except Refused as refused:
        reasons = Counter(reason(f) for f in refused.findings if f.severity is Severity.ERROR)
        out |= {"refused": True, "reasons": dict(reasons), "stops": list(reasons)}
    out["seconds"] = time.perf_counter() - began
    return out


def _crossed(given: dict[str, Any]) -> dict[str, Any]:
    source: str | Loaded = given["files"][0]
    robot, from_robot = given["robot"], given["from_robot"]
    process = None
    if len(given["files"]) > 1:
        from assistant.compiler.arms import robot_of

        (task, *_) = _same(given["files"])
        source = load_task(task, robot=robot_of(from_robot))
    language = given["language"]

    def into(proving: Proving | None) -> Translation:
        return translate(
            source,
            to=given["to"],
            robot=robot,
            from_robot=from_robot,
            process=process,
            language=language,
            proving=proving,
        )

    first = into(None)
    totals = first.totals
    errors = [f for f in first.compiled.found if f.severity is Severity.ERROR]
    library = not given["begins"]
    others = [f for f in errors if not (library and f.code == NO_MAIN)]
    whole = totals["not"] == 0 and not others
    reasons: Counter[str] = Counter()
    for row in first.rows:
        if row.level == "not":
            told = next(f for f in row.reasons if f.severity is Severity.ERROR)
            reasons[reason(told)] += row.count
    out: dict[str, Any] = {
        "said": totals["supported"],
        "partly": totals["partial"],
        "not": totals["not"],
        "whole": whole,
        "reasons": dict(reasons),
        "stops": sorted({reason(f) for f in others}),
    }
    if whole and first.ok and given["proof"] and not library:
        out |= _proven(into(Proving(seconds=given["proof"])))
    return out


def _proven(second: Translation) -> dict[str, Any]:
    motion = second.motion
    if motion is None:
        return {"proof": "not run"}
    if motion.holds:
        ran = motion.found is not None and motion.found.runs
        return {"proof": "equal" if ran else "not run"}
    wrong = [f for f in motion.findings if f.severity is Severity.ERROR]
    differs = any(f.code == "CO110" for f in wrong)
    return {"proof": "different" if differs else "cannot run", "why": [f.message for f in wrong]}


def _same(files: list[str]) -> tuple[Task, ...]:
    """The task of these files, as they were grouped."""
    found = [task for task in tasks_of(files) if len(task.files) > 1]
    whole = next((task for task in found if set(task.files) == set(files)), None)
    return (whole or Task(files[0], tuple(files), "rapid"),)


DECLARING = ("LOCAL", "TASK", "CONST", "PERS", "VAR", "DEF")
"""Words before the type of data."""


def reason(finding: Diagnostic) -> str:
    """A finding without what only one program has: of a text its first word or its type."""
    message = re.sub(r"`([^`]*)`", lambda quoted: f"`{_kind(quoted[1])}`", finding.message)
    message = re.sub(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w])", "#", message)
    return f"{finding.code} {' '.join(message.split())}"[:SHOWN]


def _kind(text: str) -> str:
    words = text.split()
    if len(words) < 2 and not re.search(r"\W", text.strip(";")):
        return "…"
    for place, word in enumerate(words):
        if word.upper() not in DECLARING:
            first = re.split(r"[^\w.%]", word)[0] or word[:1]
            return " ".join([*words[:place], first, "…"])
    return "…"


def main() -> None:
    given = json.load(sys.stdin)
    with tempfile.TemporaryDirectory() as folder:
        given["work"] = str(Path(folder))
        print(json.dumps(crossed(given)))


if __name__ == "__main__":
    main()

"""One task in another language, in a process of its own: what of it is said, as JSON."""

from __future__ import annotations

import json
import re
import sys
import time
from collections import Counter
from typing import Any

from assistant.compiler import Loaded, load, translate
from assistant.compiler.arms import robot_of
from assistant.compiler.filling import in_neutral_cell
from assistant.compiler.motion import Proving
from assistant.compiler.tasks import Task, load_task, tasks_of
from assistant.compiler.translating import LEVELS, Translation
from assistant.program.diagnostics import Diagnostic, Refused, Severity

NO_MAIN = "MB245"
"""What is said of a library that a program cannot begin with."""
SHOWN = 400
"""Characters of a reason that are told."""


def crossed(given: dict[str, Any]) -> dict[str, Any]:
    """What becomes of a task.

    given: files, language, begins, to, robot, from_robot, proof (seconds, 0 for none).
    """
    began = time.perf_counter()
    out: dict[str, Any] = {
        "alone": [0, 0, 0],
        "alone_whole": False,
        "said": 0,
        "partly": 0,
        "not": 0,
        "whole": False,
        "proof": "not run",
    }
    try:
        out |= _crossed(given)
    except Refused as refused:
        reasons = Counter(reason(f) for f in refused.findings if f.severity is Severity.ERROR)
        out |= {"refused": True, "reasons": dict(reasons), "stops": list(reasons)}
    out["seconds"] = time.perf_counter() - began
    return out


def _crossed(given: dict[str, Any]) -> dict[str, Any]:
    loaded = _loaded(given)
    library = not given["begins"]
    plain = _into(loaded, given, None)
    alone = plain.totals
    out = {"alone": [alone[level] for level in LEVELS], "alone_whole": _whole(plain, library)}
    filled = in_neutral_cell(loaded)
    first = _into(filled, given, None)
    totals = first.totals
    reasons: Counter[str] = Counter()
    for row in first.rows:
        if row.level == "not":
            told = next(f for f in row.reasons if f.severity is Severity.ERROR)
            reasons[reason(told)] += row.count
    whole = _whole(first, library)
    out |= {
        "said": totals["supported"],
        "partly": totals["partial"],
        "not": totals["not"],
        "whole": whole,
        "reasons": dict(reasons),
        "stops": sorted({reason(f) for f in _hindrances(first, library)}),
    }
    if whole and first.ok and given["proof"] and not library:
        out |= _proven(_into(filled, given, Proving(seconds=given["proof"])))
    return out


def _loaded(given: dict[str, Any]) -> Loaded:
    files, robot = given["files"], robot_of(given["from_robot"])
    if len(files) == 1:
        return load(files[0], robot=robot, language=given["language"])
    return load_task(_same(files), robot=robot)


def _into(loaded: Loaded, given: dict[str, Any], proving: Proving | None) -> Translation:
    arms = {"robot": given["robot"], "from_robot": given["from_robot"]}
    return translate(loaded, to=given["to"], proving=proving, **arms)


def _hindrances(done: Translation, library: bool) -> list[Diagnostic]:
    errors = [f for f in done.compiled.found if f.severity is Severity.ERROR]
    return [f for f in errors if not (library and f.code == NO_MAIN)]


def _whole(done: Translation, library: bool) -> bool:
    return done.totals["not"] == 0 and not _hindrances(done, library)


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


def _same(files: list[str]) -> Task:
    """The task of these files, as they were grouped."""
    whole = (task for task in tasks_of(files) if set(task.files) == set(files))
    return next(whole, None) or Task(files[0], tuple(files), "rapid")


DECLARING = ("LOCAL", "TASK", "CONST", "PERS", "VAR", "DEF")
"""Words before the type of data."""


def reason(finding: Diagnostic) -> str:
    """A finding without what only one program has: of a text its first word or its type."""
    message = re.sub(r"(statement )?`([^`]*)`", _shortened, finding.message)
    message = re.sub(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w])", "#", message)
    return f"{finding.code} {' '.join(message.split())}"[:SHOWN]


def _shortened(quoted: re.Match[str]) -> str:
    before, text = quoted[1] or "", quoted[2]
    kind = text.strip(";") if before and text.strip(";").isidentifier() else _kind(text)
    return f"{before}`{kind}`"


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
    print(json.dumps(crossed(json.load(sys.stdin))))


if __name__ == "__main__":
    main()

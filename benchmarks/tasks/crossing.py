"""One task in another language: what of it is said, and what is not, by its reason."""

from __future__ import annotations

import re
import time
from collections import Counter
from dataclasses import dataclass
from typing import Any

from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.compiler import Loaded, load, translate
from assistant.compiler.arms import robot_of
from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.compiler.motion_proof import Proving
from assistant.compiler.program_files import Task, load_task
from assistant.compiler.translation import LEVELS, Translation
from assistant.robots import Robot

NO_MAIN = "MB245"
"""What is said of a library that a program cannot begin with."""
SHOWN = 400
"""Characters of a reason that are told."""


@dataclass(frozen=True, slots=True)
class Crossing:
    """How a task is tried. proof: seconds, 0 for none."""

    to: str
    robot: str | None
    from_robot: str | None
    proof: float


NOTHING: dict[str, Any] = {
    "alone": [0, 0, 0],
    "alone_whole": False,
    "said": 0,
    "partly": 0,
    "not": 0,
    "whole": False,
    "proof": "not run",
    "reasons": {},
    "stops": [],
}
"""What is known of a task that nothing could be made of."""


def crossed(task: Task, how: Crossing) -> dict[str, Any]:
    """What becomes of a task."""
    began = time.perf_counter()
    out = dict(NOTHING)
    try:
        out |= _crossed(task, how)
    except Refused as refused:
        reasons = Counter(reason(f) for f in refused.findings if f.severity is Severity.ERROR)
        out |= {"reasons": dict(reasons), "stops": list(reasons)}
    except Exception as error:  # noqa: BLE001 - a crash is what is looked for
        out |= {"stops": [f"crashed: {error!r}"[:SHOWN]]}
    return out | {"seconds": time.perf_counter() - began}


def _crossed(task: Task, how: Crossing) -> dict[str, Any]:
    loaded = _loaded(task, robot_of(how.from_robot))
    library = not task.begins
    plain = _into(loaded, how, None)
    alone = plain.totals
    out = {"alone": [alone[level] for level in LEVELS], "alone_whole": _whole(plain, library)}
    filled = with_neutral_cell(loaded)
    first = _into(filled, how, None)
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
    if whole and first.ok and how.proof and not library:
        out |= _proven(_into(filled, how, Proving(seconds=how.proof)))
    return out


def _loaded(task: Task, robot: Robot | None) -> Loaded:
    if len(task.files) == 1 and not task.findings:
        return load(task.files[0], robot=robot, language=task.language)
    return load_task(task, robot=robot)


def _into(loaded: Loaded, how: Crossing, proving: Proving | None) -> Translation:
    return translate(loaded, to=how.to, proving=proving, robot=how.robot, from_robot=how.from_robot)


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

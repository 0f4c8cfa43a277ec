"""What a drawn task promises: nothing of it is dropped, and what is whole does the same."""

from __future__ import annotations

import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from assistant.base.diagnostics import Severity
from assistant.compiler import Translation, translate
from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.compiler.loader import Loaded
from assistant.compiler.motion_proof import Proving
from assistant.compiler.program_files import load_task, tasks_of
from tests.fuzz.target import promise
from tests.fuzz.tasks.drawing import Drawn, drawn

TO = "melfa-basic-6"


@dataclass(frozen=True, slots=True)
class Passed:
    """totals: statements by their level. whole: whether all of it was said, and proven."""

    totals: dict[str, int]
    whole: bool


def passes(seed: str, *, seconds: float = 3.0, to: str = TO) -> Passed:
    """Translates the task of a seed; raises Broken for a promise that is not kept.

    seconds: that its proof by motion may take.
    """
    task = drawn(seed)
    with tempfile.TemporaryDirectory() as folder:
        done = translate(
            _loaded(task, Path(folder)), to=to, draft=True, proving=Proving(seconds=seconds)
        )
        _told(task, done, Path(folder))
    _nothing_dropped(task, done)
    whole = done.totals["not"] == 0
    if whole:
        _does_the_same(done, task.plain)
    promise(whole or not task.plain, "a plain task is not whole", _reasons(done))
    return Passed({str(level): count for level, count in done.totals.items()}, whole)


def _loaded(task: Drawn, folder: Path) -> Loaded:
    for name, text in task.files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    found = tasks_of([str(folder / name) for name in sorted(task.files)])
    promise(len(found) == 1, "one task is read as several", [one.files for one in found])
    promise(len(found[0].files) == len(task.files), "files of the task are left out")
    return with_neutral_cell(load_task(found[0]))


def _told(task: Drawn, done: Translation, folder: Path) -> None:
    """Each statement is in the report exactly once."""
    told: Counter[tuple[str, int]] = Counter()
    for row in done.rows:
        path = Path(row.place.path or "").relative_to(folder).as_posix()
        told[path, row.place.line] += row.count
    missing, more = task.statements - told, told - task.statements
    promise(not missing, "statements are not in the report", [_line(task, at) for at in missing])
    promise(not more, "statements are twice in the report", [_line(task, at) for at in more])


def _nothing_dropped(task: Drawn, done: Translation) -> None:
    """What is not said stands in the draft as a comment, what is said as itself."""
    refused = done.totals["not"] > 0
    promise(not (refused and done.compiled.ok), "not all is said, and it is given out as if it was")
    promise(bool(done.files) or not refused, "there is no draft", _reasons(done))
    if not done.files:
        return
    text = "\n".join(data.decode("utf-8", "replace") for data in done.files.values())
    partly = {(row.place.line, row.text) for row in done.rows if row.level == "partial"}
    told = {line for line, _ in partly}
    for mark, at in task.marks.items():
        there = str(mark) in text or at[1] in told
        promise(there, "a statement is dropped", _line(task, at))
    for row in done.rows:
        if row.level == "not":
            promise(row.text.split(";")[0][:40] in text, "what is not said is dropped", row.text)


def _does_the_same(done: Translation, plain: bool) -> None:
    """What an interpreter does not know may end the proof of a task that is not plain."""
    motion = done.motion
    promise(motion is not None and done.compiled.proof.holds, "what is whole is not proven")
    if motion is not None:
        wrong = [f"{f.code} {f.message}" for f in motion.findings if f.severity is Severity.ERROR]
        unknown = not plain and {f.code for f in motion.findings} >= {"CO111"}
        promise(motion.holds or unknown, "what is whole does something else", wrong)


def _reasons(done: Translation) -> list[str]:
    rows = [row for row in done.rows if row.level == "not"]
    return [f"{row.text}: {row.reasons[0].code} {row.reasons[0].message}" for row in rows]


def _line(task: Drawn, at: tuple[str, int]) -> str:
    return f"{at[0]}:{at[1]}: {task.files[at[0]].splitlines()[at[1] - 1].strip()}"

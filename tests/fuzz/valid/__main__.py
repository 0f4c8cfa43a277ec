"""Goes on with the valid programs: `python -m tests.fuzz.valid --seconds 60 [--seed kind:number]`.

State lies in `.fuzz/valid/`: how many programs of each kind there were, which rows of the tables
they called, and the failures, each told by its seed and by the least text that still fails.
"""

from __future__ import annotations

import argparse
import collections
import hashlib
import json
import os
import signal
import time
import traceback
from random import Random
from types import FrameType
from typing import Any, Final

from assistant import languages
from tests.fuzz.state import PLACE, kind_of
from tests.fuzz.valid.passing import STAGES, Stage, source_of
from tests.fuzz.valid.table import GENERATORS

FOLDER: Final = PLACE / "valid"
SECONDS: Final = 20.0
REDUCING: Final = 40.0
"""Seconds that a program may take at a stage, and that a failure is made smaller for."""


class TooSlow(BaseException):
    pass


def _too_slow(number: int, frame: FrameType | None) -> None:
    raise TooSlow


def failure(stage: Stage, kind: str, text: str, seed: str) -> BaseException | None:
    """What a program fails with at a stage, None if it does not."""
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        stage.run(kind, text, Random(f"{seed} {stage.name}"))
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return error
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return None


def passed(kind: str, text: str, seed: str) -> tuple[Stage, BaseException] | None:
    """The first stage that a program fails at, and what it fails with."""
    chance = Random(seed)
    for stage in STAGES[kind]:
        if chance.random() < stage.often:
            error = failure(stage, kind, text, seed)
            if error is not None:
                return stage, error
    return None


def whole(kind: str, lines: list[str]) -> bool:
    """Whether lines are still a program without a syntax error."""
    if not lines or kind == "pseudo":
        return bool(lines)
    return not languages.get(kind).parse(source_of(kind, "".join(lines))).findings


def reduced(stage: Stage, kind: str, text: str, seed: str, what: str) -> str:
    """The least lines that still fail in the same way."""
    lines, size, end = text.splitlines(True), 16, time.monotonic() + REDUCING
    while size:
        at = 0
        while at < len(lines):
            fewer = [*lines[:at], *lines[at + size :]]
            error = failure(stage, kind, "".join(fewer), seed) if whole(kind, fewer) else None
            if error is not None and kind_of(error) == what:
                lines = fewer
            else:
                at += size
            if time.monotonic() > end:
                return "".join(lines)
        size //= 2
    return "".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", help="only this program: a kind and its number, as rapid:17")
    parser.add_argument("--kinds", nargs="*", default=list(GENERATORS))
    given = parser.parse_args()
    os.environ["ROBOT_ASSISTANT_TRACEBACK"] = "1"
    signal.signal(signal.SIGVTALRM, _too_slow)
    if given.seed:
        kind, _, number = given.seed.partition(":")
        _one(kind, number)
        return
    FOLDER.mkdir(parents=True, exist_ok=True)
    state = FOLDER / "state.json"
    known: dict[str, Any] = json.loads(state.read_text()) if state.exists() else {}
    counts: dict[str, int] = known.get("programs", {})
    reached = collections.Counter(known.get("reached", {}))
    failures: dict[str, Any] = known.get("failures", {})
    start = told = time.monotonic()
    while time.monotonic() - start < given.seconds:
        for kind in given.kinds:
            number = counts.get(kind, 0)
            if kind == "pseudo" and sum(counts.values()) % 3:
                continue  # its text takes longest to read
            counts[kind] = number + 1
            seed = f"{kind} {number}"
            text, rows = GENERATORS[kind](Random(seed))
            reached.update(f"{kind.rstrip('-456')} {row}" for row in rows)
            failed = passed(kind, text, seed)
            if failed is None:
                continue
            stage, error = failed
            what = kind_of(error)
            if what not in failures:
                least = reduced(stage, kind, text, seed, what)
                again = failure(stage, kind, least, seed) or error
                trace = "".join(traceback.format_exception(again))[-5000:]
                name = hashlib.sha1(what.encode()).hexdigest()[:10]
                (FOLDER / f"{name}.txt").write_text(
                    f"{kind}:{number}\n{what}\n\n{least}\n\n{trace}", "utf-8", "replace"
                )
                failures[what] = {"seed": f"{kind}:{number}", "times": 0, "file": name}
                print(f"{kind}:{number} {name} {what}", flush=True)
            failures[what]["times"] += 1
        if time.monotonic() - told > 10:
            told = time.monotonic()
            _save(state, counts, reached, failures)
    _save(state, counts, reached, failures)
    print(counts, sum(counts.values()), "programs;", len(reached), "rows of tables reached")
    for what, one in sorted(failures.items(), key=lambda pair: -pair[1]["times"]):
        print(one["times"], one["seed"], one["file"], what)


def _one(kind: str, number: str) -> None:
    seed = f"{kind} {number}"
    text, _ = GENERATORS[kind](Random(seed))
    failed = passed(kind, text, seed)
    if failed is None:
        print(text)
        print("passes")
        return
    stage, error = failed
    print(reduced(stage, kind, text, seed, kind_of(error)))
    traceback.print_exception(error)


def _save(state: Any, counts: Any, reached: Any, failures: Any) -> None:
    new = state.with_suffix(".new")
    new.write_text(json.dumps({"programs": counts, "reached": reached, "failures": failures}))
    new.replace(state)


if __name__ == "__main__":
    main()

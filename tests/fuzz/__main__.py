"""The command behind `make fuzz`: each target in a process of its own, in turn."""

from __future__ import annotations

import argparse
import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from random import Random

from tests.fuzz.minimising import minimised
from tests.fuzz.state import PLACE, again, state_of
from tests.fuzz.table import TARGETS
from tests.fuzz.target import CASES, ROOT, Target
from tests.fuzz.worker import CURRENT, ENGINES

PATIENCE = 120.0
"""Seconds that a process may live on after its time, until it counts as hanging."""

MOST_DEATHS = 20
"""Processes that may end in the middle of an input, in one run of a target."""


class Died(Exception):
    """A process that ended, or had to be ended, in the middle of an input."""


def main() -> int:
    given = _arguments().parse_args()
    targets = [TARGETS[name] for name in given.targets] or list(TARGETS.values())
    if given.again is not None:
        os.environ["ROBOT_ASSISTANT_TRACEBACK"] = "1"
        for target in targets:
            target.run(given.again.read_bytes())
        print("nothing failed")
        return 0
    if given.keep is not None:
        for target in targets:
            small = minimised(target, given.keep.read_bytes())
            path = CASES / target.name / (given.name or given.keep.stem)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(small)
            print(f"wrote {path}, {len(small)} bytes")
        return 0
    for target in targets:
        each = given.seconds / len(targets) if given.inputs is None else 1e9
        run(target, each, given.inputs or 1 << 60, given.place, given.engine)
    return tell(targets, given.place)


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    found = importlib.util.find_spec("atheris") is not None
    parser.add_argument("targets", nargs="*", choices=[*TARGETS, []], metavar="TARGET")
    parser.add_argument("--seconds", type=float, default=300.0, help="of all targets together")
    parser.add_argument("--inputs", type=int, help="of each target, instead of a time")
    parser.add_argument("--engine", choices=ENGINES, default="atheris" if found else "changes")
    parser.add_argument("--place", type=Path, default=PLACE, help="what runs leave for the next")
    parser.add_argument("--again", type=Path, metavar="FILE", help="try one input")
    parser.add_argument("--keep", type=Path, metavar="FILE", help="make one input a case")
    parser.add_argument("--name", help="of the case; default that of the file")
    return parser


def run(target: Target, seconds: float, inputs: int, place: Path, engine: str) -> None:
    """Runs a target until its time or its inputs are used up, again where its process died."""
    state, before = state_of(target, place), state_of(target, place).counts().inputs
    end = time.monotonic() + seconds
    for _ in range(MOST_DEATHS):
        left = inputs - (state.counts().inputs - before)
        seconds = end - time.monotonic()
        if left <= 0 or seconds <= 0:
            break
        command = [sys.executable, "-m", "tests.fuzz.worker", target.name, f"--place={place}"]
        command += [f"--seconds={seconds}", f"--inputs={left}", f"--engine={engine}"]
        command += [f"--seed={Random().randrange(1, 1 << 31)}"]
        with (state.folder / "log").open("wb") as log:
            worker = subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log)
            try:
                status = worker.wait(timeout=seconds + PATIENCE)
            except subprocess.TimeoutExpired:
                worker.kill()
                status = worker.wait()
            except KeyboardInterrupt:
                worker.wait(timeout=PATIENCE)
                raise
        if status == 0:
            break
        data = (state.folder / CURRENT).read_bytes()
        length = int.from_bytes(data[:4], "little")
        state.fail(target, data[4 : 4 + length], Died(f"the process ended with {status}"))
    counts = state.counts()
    print(
        f"{target.name}: {counts.inputs - before} inputs, {counts.inputs} so far, "
        f"{len(state.inputs())} kept, {len(state.failed())} failures",
        flush=True,
    )


def tell(targets: Sequence[Target], place: Path) -> int:
    """The sums of all runs, and each failure with the command that tries it again."""
    inputs = failures = 0
    for target in targets:
        state = state_of(target, place)
        inputs += state.counts().inputs
        for path in state.failed():
            failures += 1
            last = path.with_suffix(".txt").read_text("utf-8", "replace").strip().splitlines()[-1]
            print(f"{last}\n  {again(target, path)}")
    print(f"{inputs:,} inputs so far, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

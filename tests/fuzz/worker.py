"""A process that runs one target: by atheris, or by our own changes where that is not there.

Both go on from the corpus of earlier runs, and leave there what reached new code. Ours learns of
new code by `sys.monitoring` (Python 3.12 and later); before, it only tries changes of the seeds.
"""

from __future__ import annotations

import argparse
import contextlib
import mmap
import os
import signal
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from random import Random
from types import CodeType, FrameType
from typing import Final

MOST_MEMORY: Final = 4 << 30
"""Bytes of address space; an input that needs more fails."""
AT_ONCE: Final = 10.0
"""Seconds after which counts are written."""
CURRENT: Final = "current"
"""The file with the input at hand, for whoever finds this process dead."""
ROOM: Final = 1 << 20


class TooSlow(BaseException):
    """An input took longer than its target allows; a BaseException, so that nobody hides it."""


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("target")
    parser.add_argument("--place", type=Path, required=True)
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--inputs", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--engine", choices=ENGINES, required=True)
    given = parser.parse_args()
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    os.environ["ROBOT_ASSISTANT_TRACEBACK"] = "1"  # what fails inside is raised
    ENGINES[given.engine](given)


class Run:
    """What both engines do with an input."""

    def __init__(self, given: argparse.Namespace) -> None:
        from tests.fuzz.state import state_of
        from tests.fuzz.table import TARGETS

        self.target = TARGETS[given.target]
        self.state = state_of(self.target, given.place)
        self.started = self.told = time.monotonic()
        self.end = self.started + given.seconds
        self.left = given.inputs
        self._new = 0
        with (self.state.folder / CURRENT).open("w+b") as file:
            file.truncate(ROOM)
            self._current = mmap.mmap(file.fileno(), ROOM)
        signal.signal(signal.SIGVTALRM, _too_slow)

    def warm(self, inputs: Iterable[bytes]) -> None:
        """Runs sound inputs, at any length: modules that are needed are imported by that."""
        for data in inputs:
            with contextlib.suppress(Exception):  # it is run again, and counted then
                self.target.run(data)

    def __call__(self, data: bytes) -> None:
        """Runs one input; what fails is written. Ends the process when its time is up."""
        self._current[: 4 + len(data[: ROOM - 4])] = len(data).to_bytes(4, "little") + data
        signal.setitimer(signal.ITIMER_VIRTUAL, self.target.seconds)
        try:
            self.target.run(data)
        except KeyboardInterrupt:
            self.finish()
        except BaseException as error:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            if (path := self.state.fail(self.target, data, error)) is not None:
                print(f"failed: {path}", file=sys.stderr, flush=True)
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        self._new += 1
        self.left -= 1
        now = time.monotonic()
        if self.left <= 0 or now >= self.end:
            self.finish()
        if now - self.told > AT_ONCE:
            self._count(now)

    def _count(self, now: float) -> None:
        self.state.count(self._new, now - self.told)
        self._new, self.told = 0, now

    def finish(self) -> None:
        """libFuzzer does not return, so the process ends here."""
        self._count(time.monotonic())
        sys.stderr.flush()
        from tests.fuzz.target import leave

        leave()
        os._exit(0)


def _too_slow(number: int, frame: FrameType | None) -> None:
    raise TooSlow


# ------------------------------------------------------------------------------ engines


def by_atheris(given: argparse.Namespace) -> None:
    """libFuzzer chooses and changes inputs by the branches that they take; half of the changes
    are ours."""
    import atheris

    with atheris.instrument_imports(include=["assistant"]):
        run = Run(given)
        seeds = run.state.folder / "seeds"
        seeds.mkdir(exist_ok=True)
        sound = [*run.target.seeds(), *(case.read_bytes() for case in run.target.cases())]
        run.warm(sound)
        for number, data in enumerate(sound):
            (seeds / str(number)).write_bytes(data)
        from tests.fuzz.mutating import changed, stock

        parts = stock(run.target, sound)

        def change(data: bytes, most: int, seed: int) -> bytes:
            chance = Random(seed)
            if chance.random() < 0.5:
                return bytes(atheris.Mutate(data, most))
            return changed(data, parts, chance)[:most]

        options = [
            f"-max_len={run.target.most}",
            f"-seed={given.seed}",
            "-verbosity=0",
        ]
        options += ["-rss_limit_mb=0", "-handle_segv=0", "-handle_abrt=0", "-handle_int=0"]
        atheris.Setup(
            ["fuzz", str(run.state.corpus), str(seeds), *options], run, custom_mutator=change
        )
        atheris.Fuzz()


def by_changes(given: argparse.Namespace) -> None:
    """Changes of the seeds, and of those inputs that reached new lines."""
    from tests.fuzz.mutating import changed, stock

    run = Run(given)
    news = new_lines()
    inputs = [*run.target.seeds(), *(case.read_bytes() for case in run.target.cases())]
    run.warm(inputs)
    known = run.state.inputs()
    for data in (*inputs, *known):
        run(data)
    news()
    inputs += known
    parts = stock(run.target, inputs)
    chance = Random(given.seed)
    while True:
        last = inputs[-20:] if chance.random() < 0.3 else inputs
        data = changed(chance.choice(last), parts, chance)
        run(data)
        if news():
            run.state.keep(data)
            inputs.append(data)


def new_lines() -> Callable[[], bool]:
    """A function that tells whether lines of ours ran for the first time since it was asked."""
    if sys.version_info < (3, 12):
        return lambda: False
    watching, found = sys.monitoring, [False]
    tool = watching.COVERAGE_ID
    watching.use_tool_id(tool, "fuzz")

    def line(code: CodeType, number: int) -> object:
        found[0] = found[0] or "assistant" in code.co_filename
        return watching.DISABLE

    watching.register_callback(tool, watching.events.LINE, line)
    watching.set_events(tool, watching.events.LINE)

    def news() -> bool:
        told, found[0] = found[0], False
        return told

    return news


ENGINES: Final[dict[str, Callable[[argparse.Namespace], None]]] = {
    "atheris": by_atheris,
    "changes": by_changes,
}

if __name__ == "__main__":
    main()

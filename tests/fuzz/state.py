"""What earlier runs left: the corpus of a target, its counts, and inputs that failed."""

from __future__ import annotations

import hashlib
import json
import shlex
import traceback
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from tests.fuzz.target import ROOT, Broken, Target

PLACE: Final = ROOT / ".fuzz"
COUNTS: Final = "counts.json"


@dataclass(slots=True)
class Counts:
    """Of all runs so far. seconds: that they took."""

    inputs: int = 0
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class State:
    """The folder of a target; it is there."""

    folder: Path

    @property
    def corpus(self) -> Path:
        return self.folder / "corpus"

    @property
    def failures(self) -> Path:
        return self.folder / "failures"

    def counts(self) -> Counts:
        try:
            return Counts(**json.loads((self.folder / COUNTS).read_bytes()))
        except (OSError, ValueError, TypeError):
            return Counts()

    def count(self, inputs: int, seconds: float) -> None:
        """Adds to the counts."""
        counts = self.counts()
        counts.inputs += inputs
        counts.seconds += seconds
        written = self.folder / f"{COUNTS}.new"
        written.write_text(json.dumps(asdict(counts)))
        written.replace(self.folder / COUNTS)

    def keep(self, data: bytes) -> None:
        """Keeps an input that led where none had led."""
        (self.corpus / hashlib.sha1(data).hexdigest()).write_bytes(data)

    def inputs(self) -> list[bytes]:
        return [path.read_bytes() for path in sorted(self.corpus.iterdir())]

    def failed(self) -> list[Path]:
        return sorted(path for path in self.failures.iterdir() if path.suffix == ".input")

    def fail(self, target: Target, data: bytes, error: BaseException) -> Path | None:
        """Writes an input that failed; None if another one is there that fails in the same way."""
        name = hashlib.sha1(kind_of(error).encode()).hexdigest()[:12]
        path = self.failures / f"{name}.input"
        if path.exists() and path.stat().st_size <= len(data):
            return None
        known = path.exists()
        path.write_bytes(data)
        told = "".join(traceback.format_exception(error))[-6000:]
        path.with_suffix(".txt").write_text(f"{again(target, path)}\n\n{told}", "utf-8", "replace")
        return None if known else path


def again(target: Target, path: Path) -> str:
    """The command that tries an input of a target again."""
    return f"python -m tests.fuzz {target.name} --again {shlex.quote(str(path))}"


def state_of(target: Target, place: Path = PLACE) -> State:
    state = State(place / target.name)
    for folder in (state.corpus, state.failures):
        folder.mkdir(parents=True, exist_ok=True)
    return state


def kind_of(error: BaseException) -> str:
    """What tells failures apart: a promise that was broken, or where an error was raised."""
    if isinstance(error, Broken):
        return error.what
    where = [f"{frame.f_code.co_filename}:{frame.f_code.co_name}" for frame in _frames(error)]
    own = [one for one in where if "/assistant/" in one] or where
    last = own[-1:] if not isinstance(error, RecursionError) else own[:1]
    return f"{type(error).__name__} {' '.join(last)}"


def _frames(error: BaseException) -> Iterator[traceback.types.FrameType]:
    for frame, _ in traceback.walk_tb(error.__traceback__):
        yield frame

"""`python -m tests.sweep`: prints how many faults there were, and what they lost.

Every command of `commands` runs in forks of this process, which has done it once. It is cut
off or fails at each call that changes files, one after another. Then every name must hold all old
or all new bytes, the exit status and the message must be right, and the next run must tell what was
left and clean it up.
"""

from __future__ import annotations

import argparse
import gc
import io
import json
import os
import re
import shutil
import signal
import sys
import tempfile
import traceback
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Never

from tests.sweep import shim
from tests.sweep.commands import COMMANDS, Command
from tests.sweep.kinds import KINDS, Kind

State = Mapping[str, bytes]
"""The files of a folder by their names in it."""
HOLDING: Final = ".robot-assistant-"
ARRIVING: Final = ".arriving-"
PATIENCE: Final = 60
"""Seconds, after which a command hangs."""
NO_COMPILER: Final = "there is no C compiler here: 0 faults, 0 losses"
CODE: Final = re.compile(r"^[A-Z]{2}\d{3} error", re.MULTILINE)
LEFT_OUT: Final = re.compile(r"(^|/)(lock|\.robot-assistant/virtual/.*)$")
"""What nobody reads again, or what is a controller's own."""


class Lost(Exception):
    """What a fault has lost, in words."""


@dataclass(slots=True)
class Done:
    """How a command ended. status: negative for a signal. fired: how often the fault happened."""

    status: int
    said: str
    count: int
    fired: int
    call: str


@dataclass(slots=True)
class Sweep:
    """One command with all that happens to it."""

    name: str
    command: Command
    fault: shim.Fault
    folder: Path
    old: State = field(default_factory=dict)
    new: State = field(default_factory=dict)
    faults: int = 0
    losses: list[str] = field(default_factory=list)
    ends: Counter[str] = field(default_factory=Counter)

    def prepare(self) -> None:
        """What is there before and after, when nothing happens."""
        self.put(self._given())
        for words in self.command.before:
            self.ran(words)
        self.put({**self.state(), **{n: t.encode() for n, t in self.command.then.items()}})
        before = self.state()
        done = self.run()
        expect(done.status == 0, f"it does not run at all: {done.said}")
        self.new = self.state()
        made = [name for name in self.new if self.new[name] != before.get(name)]
        expect(bool(made), "it writes nothing")
        self.old = dict(before)
        if self.command.over:
            over = {name: f"old {name}".encode() for name in made[::2]}
            self.old = {**before, **over}
        self.put(self.old)
        again = self.run()
        expect(self.state() == self.new, "it writes something else each time")
        expect(again.status == 0, again.said)

    def _given(self) -> State:
        return {name: text.encode() for name, text in self.command.given.items()}

    def sweep(self, kinds: Sequence[Kind], every: int, first: int) -> None:
        for number, kind in enumerate(kinds):
            at = (first + number) % every
            while self.point(kind, at):
                at += every

    def point(self, kind: Kind, at: int) -> bool:
        """Whether there was such a call."""
        self.put(self.old)
        done = self.run(kind, at)
        if not done.fired:
            return False
        self.faults += 1
        try:
            self.judge(kind, done)
        except Lost as lost:
            self.losses.append(f"{self.name}, {kind.name} at call {at} ({done.call}): {lost}")
        return True

    # --------------------------------------------------------------------------- judging

    def judge(self, kind: Kind, done: Done) -> None:
        state = self.state()
        self.check_names(state, kind)
        left = [one for one in self.folder.rglob(f"{HOLDING}*") if one.is_dir()]
        stuck = "CO205" in done.said
        self.check_told(kind, done, state)
        if left:
            by_signal = kind.kind == shim.SIGNAL and not kind.kills
            expect(not by_signal, f"left {left[0].name}")
            self.check_put_in_order(left)
        else:
            expect(not stuck, "nothing is left of what could not be put back")
            whole = state in (self.old, self.new) or not self.command.together
            expect(whole, f"mixed: {self.differ(state)}")
        self.ends[self.word(state)] += 1
        if self.state() == (self.old if not left else None):
            return  # that the next run does what it should is known
        if self.state() == self.new and not self.command.again:
            return
        again = self.run()
        expect(again.status == 0, f"the next run ends so: {again.said}")
        expect(self.state() == self.new, f"the next run: {self.differ(self.state())}")
        expect(not list(self.folder.rglob(f"{HOLDING}*")), "the next run leaves a folder behind")

    def check_names(self, state: State, kind: Kind | None = None) -> None:
        for name in {*state, *self.old, *self.new}:
            if ARRIVING in name:  # on a virtual disk: the next who writes there takes it away
                arriving = kind is None or kind.kills or kind.kind in (shim.ALWAYS, shim.ONCE)
                expect(arriving, f"`{name}` was left behind")
                continue
            expect(name in self.old or name in self.new, f"`{name}` was left behind")
            data = state.get(name)
            known = data in (self.old.get(name), self.new.get(name))
            if name in self.command.books and data is not None:
                expect(is_whole(name, data), f"`{name}` is damaged")
                continue
            expect(known, f"`{name}` is {'gone' if data is None else 'neither old nor new'}")

    def check_sets(self, state: State) -> None:
        """Who is killed, or whose disk is gone, may have written one folder and not the other."""
        folders = {str(Path(name).parent) for name in self.new} if self.command.together else ()
        for folder in folders:
            now, old, new = (
                {name: data for name, data in one.items() if str(Path(name).parent) == folder}
                for one in (state, self.old, self.new)
            )
            expect(now in (old, new), f"mixed: {self.differ(state)}")

    def check_put_in_order(self, left: Sequence[Path]) -> None:
        """The next that writes there tells of it, and then all is old or all is new."""
        from assistant.base.file_sets import reporting_leftovers, write_files

        for holding in left:
            told: list[str] = []
            with reporting_leftovers(lambda finding, told=told: told.append(finding.code)):
                write_files({"probe": b""}, holding.parent)
            (holding.parent / "probe").unlink()
            expect(told == ["CO203"], f"the next run tells {told}")
            expect(not holding.exists(), "the next run leaves it")
        state = self.state()
        self.check_names(state)
        self.check_sets(state)

    def check_told(self, kind: Kind, done: Done, state: State) -> None:
        expect("Traceback" not in done.said, done.said)
        if kind.kills:
            expect(done.status == -signal.SIGKILL, f"it ends with {done.status}")
        elif kind.kind == shim.SIGNAL:
            name = signal.Signals(kind.what).name
            expect(done.status == 128 + kind.what, f"it ends with {done.status}: {done.said}")
            expect(done.said.endswith(f"ended by {name}\n"), f"it says {done.said!r}")
        elif done.status == 0 and not re.search(r"^CO20\d error", done.said, re.M):
            expect(state == self.new, f"it says that it is done: {self.differ(state)}")
        else:
            expect(done.status in (1, 2), f"it ends with {done.status}: {done.said}")
            expect(CODE.search(done.said), f"it says {done.said!r}")
            expect("CL900" not in done.said, done.said)
            if self.command.together and "CO205" not in done.said:
                expect(state == self.old, f"it says that nothing changed: {self.differ(state)}")

    def word(self, state: State) -> str:
        return "old" if state == self.old else "new" if state == self.new else "some of each"

    def differ(self, state: State) -> str:
        words = {
            name: "old" if state.get(name) == self.old.get(name) else "new"
            for name in sorted({*self.old, *self.new})
            if self.old.get(name) != self.new.get(name)
        }
        return ", ".join(f"{name} {word}" for name, word in words.items())

    # ----------------------------------------------------------------------------- files

    def put(self, state: State) -> None:
        """Has the folder hold that and nothing else."""
        for one in self.folder.iterdir():
            shutil.rmtree(one) if one.is_dir() and not one.is_symlink() else one.unlink()
        fixed = {name: data for name, data in self._given().items() if LEFT_OUT.search(name)}
        for name, data in {**fixed, **state}.items():
            file = self.folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)

    def state(self) -> State:
        found = {}
        for file in sorted(self.folder.rglob("*")):
            name = file.relative_to(self.folder).as_posix()
            if not file.is_dir() and HOLDING not in name and not LEFT_OUT.search(name):
                found[name] = file.read_bytes()
        return found

    # --------------------------------------------------------------------------- running

    def ran(self, words: Sequence[str]) -> None:
        done = self.run(words=words)
        expect(done.status == 0, f"{' '.join(words)}: {done.said}")

    def run(self, kind: Kind | None = None, at: int = 0, words: Sequence[str] = ()) -> Done:
        """A command in a fork of this process."""
        fault = self.fault
        fault.count = fault.fired = 0
        fault.call = b""
        fault.at, fault.kind = at, shim.NOTHING if kind is None else kind.kind
        fault.what, fault.again = (0, 0) if kind is None else (kind.what, kind.again)
        said = os.memfd_create("said")
        child = os.fork()
        if child == 0:
            act(self.folder, words or self.command.words, fault, said)
        _, status = os.waitpid(child, 0)
        text = os.pread(said, 100_000, 0).decode(errors="replace")
        os.close(said)
        status = os.waitstatus_to_exitcode(status)
        expect(status != -signal.SIGALRM, "it hangs")
        return Done(status, text, fault.count, fault.fired, fault.call.decode())


def act(folder: Path, words: Sequence[str], fault: shim.Fault, said: int) -> Never:
    """Does in this process what the command line does, and ends it."""
    from assistant.cli import main

    status: object = 99
    try:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            usual = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
            signal.signal(number, usual)
        signal.alarm(PATIENCE)
        os.chdir(folder)
        os.dup2(said, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        shim.begin(fault)
        main(list(words))
    except SystemExit as ended:
        status = ended.code or 0
    except BaseException:  # noqa: BLE001 - it is judged by who looks on
        os.write(2, traceback.format_exc().encode())
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status if isinstance(status, int) else 98)


def is_whole(name: str, data: bytes) -> bool:
    """Whether a file that tells what was done can be read."""
    if name.endswith(".npz"):
        return zipfile.ZipFile(io.BytesIO(data)).testzip() is None
    return isinstance(json.loads(data), dict)


def expect(condition: object, what: str) -> None:
    if not condition:
        raise Lost(what)


def warmed(sweep: Sweep) -> None:
    """What a command imports and works out once is there in this process."""
    from assistant.cli import main

    here = Path.cwd()
    sweep.put(sweep._given())
    os.chdir(sweep.folder)
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            main(list(sweep.command.words))
    except SystemExit:
        pass
    finally:
        os.chdir(here)


def sweeps(names: Sequence[str], folder: Path) -> Iterator[Sweep]:
    fault = shim.common()
    for name in names:
        inside = folder / name
        inside.mkdir()
        yield Sweep(name, COMMANDS[name], fault, inside)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.sweep", description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="try one of so many calls")
    parser.add_argument("names", nargs="*", default=list(COMMANDS), help="of commands")
    given = parser.parse_args()
    if not sys.platform.startswith("linux") or shim.compiler() is None:
        sys.stdout.write(f"{NO_COMPILER}\n")
        return 0
    with tempfile.TemporaryDirectory(prefix="sweep") as name:
        if shim.PRELOAD not in os.environ:
            library = shim.made(Path(name))
            words = [sys.executable, "-W", "ignore", "-m", "tests.sweep", *sys.argv[1:]]
            environment = {**os.environ, shim.PRELOAD: str(library)}
            return os.spawnve(os.P_WAIT, sys.executable, words, environment)
        return swept(given.names, given.every, Path(name))


def swept(names: Sequence[str], every: int, folder: Path) -> int:
    faults, losses = 0, []
    for number, one in enumerate(sweeps(names, folder)):
        warmed(one)
        gc.freeze()
        try:
            one.prepare()
            one.sweep(KINDS, every, number)
        except Lost as lost:
            one.losses.append(f"{one.name}: {lost}")
        ends = ", ".join(f"{count} {end}" for end, count in sorted(one.ends.items()))
        sys.stdout.write(f"{one.name}: {one.faults} faults, {len(one.losses)} losses ({ends})\n")
        sys.stdout.flush()
        faults += one.faults
        losses += one.losses
    for loss in losses:
        sys.stdout.write(f"  {loss}\n")
    sys.stdout.write(f"{faults} faults, {len(losses)} losses\n")
    return 1 if losses else 0


if __name__ == "__main__":
    sys.exit(main())

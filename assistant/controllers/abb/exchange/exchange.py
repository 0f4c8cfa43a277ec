"""The PC's side of an exchange of poses by files: a request, its answer, one after the other.

with controllers.connect("ftp://engineer@192.168.125.1") as programs:
    with PoseExchange(programs) as exchange:
        start = exchange.current_pose()
        exchange.move_to(start.pose.offset(z=-20.0))
"""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import ArrayLike

from assistant.controllers import rules as common
from assistant.controllers.abb.exchange import messages, rules
from assistant.controllers.abb.exchange.claiming import Claim, Files, HandsOver
from assistant.controllers.abb.exchange.messages import Answer, Configuration, Word
from assistant.controllers.abb.exchange.module import file_names
from assistant.controllers.abb.exchange.recording import FIELDS, Spent, add
from assistant.controllers.controller import Programs
from assistant.controllers.recording import Recording
from assistant.program import rotations
from assistant.program.arrays import Floats, reals
from assistant.program.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.program.path import Kind, Path

Check = Callable[[Floats, Floats], Mapping[int, str]]
"""Tells of poses (n, 3) mm and (n, 4) which rows, from 0, must not be sent, and why."""
Progress = Callable[[int, int, Answer], None]
"""Is told how many poses of how many have been answered, and the last answer."""

UNIT: Final = 1e-3
"""How far the length of a quaternion may be from 1; it is made a unit one."""
LARGEST_CONFIGURATION: Final = 99_999_999
"""cfx of arms that have several digits; cf1, cf4 and cf6 are quarters of a turn."""
_ROWS: Final = "state positions (n, 3) in mm and quaternions (n, 4)"
FARTHEST: Final = 100_000.0
"""mm that a coordinate has at most: beyond, it is no place of a robot."""
OFF: Final = 1.0
"""mm and degrees at most between a requested pose and that of a robot that stands there."""
SETTLE: Final = 1.0
"""Seconds after which an answer that cannot be read stays unreadable: a damaged transfer is read
again until then."""


class PoseExchange:
    """An exchange with a program that `module.Module` printed and that runs on the controller.

    A context manager: entering claims the exchange, so that no other client sends requests in
    between, and asks where the robot is, which the program must answer. Leaving it
    because of an error, or of ^C, stops the robot and ends the program (`stop`); leaving it
    otherwise lets the program wait for the next exchange.

    programs: an open session. prefix: of the files, as the module has it. timeout: seconds for an
    answer without a motion, and for one to a stop. longest: seconds for one motion. poll: seconds
    after which an answer is looked for again. check: asked before poses are sent.
    """

    def __init__(
        self,
        programs: Programs,
        *,
        prefix: str = "exchange",
        timeout: float = 10.0,
        longest: float = 240.0,
        poll: float = 0.01,
        check: Check | None = None,
    ) -> None:
        self.programs = programs
        self.recording: Final = Recording(FIELDS)
        self.spent = Spent()
        """Where the time of the last round trip went."""
        self.stopped: Answer | None = None
        """What the robot answered to a stop."""
        self.ended = ""
        """Why the exchange is over and in which state the robot is; "" while it goes on."""
        self.checked: bool | None = None
        """True if the answers have checksums, None before the first one."""
        self._names = file_names(prefix)
        self._files = Files(programs)
        self._claim = Claim(self._files, prefix)
        self._left: bytes | None = None
        self._timeout, self._longest, self._poll = timeout, longest, poll
        self._check = check
        self._number = random.randrange(1, messages.LARGEST_NUMBER // 2)  # noqa: S311 - no secret
        self._in_step = False
        self._begin = time.monotonic()

    def __enter__(self) -> Self:
        self._begin = time.monotonic()
        self._claim.take()
        try:
            self.current_pose()
        except BaseException:
            with suppress(Refused):
                self._claim.free()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            if error is not None and not self.ended:
                self._stop_after(error)
        finally:
            try:
                self._claim.free()
            except Refused:
                if error is None:
                    raise

    def current_pose(self) -> Answer:
        """Where the robot is, once its program has come to look for a request."""
        return self._ask("where", None, None, self._timeout)

    def move_to(
        self, pose: Pose, *, configuration: Configuration | None = None, through: bool = False
    ) -> Answer:
        """Goes to a pose in a line, stands still there and answers with where that is.

        through: does not stand still, but answers as soon as the program goes on, so that a next
        pose that comes in time is reached through the zone of the module. configuration: None to
        let the controller take the nearest one. Raises Refused if the pose must not be sent, or
        the robot does not go there; it stands where it was then.
        """
        positions, quaternions = self._checked([pose.position], [pose.quaternion])
        return self._move(Pose.of(positions[0], quaternions[0]), configuration, through)

    def follow(
        self,
        trajectory: Path | tuple[ArrayLike, ArrayLike],
        *,
        configurations: Sequence[Configuration] | None = None,
        through: bool = False,
        progress: Progress | None = None,
    ) -> Recording:
        """Goes to all poses in their order, each once the one before has been answered.

        trajectory: a path of lines, or columns (n, 3) mm and (n, 4). All of them are checked
        before the first is sent. Returns `recording`, which holds what came before an error too.
        """
        if isinstance(trajectory, Path):
            arcs = np.flatnonzero(np.isin(trajectory.kinds, (Kind.VIA, Kind.END)))
            if arcs.size:
                raise Refused(
                    _bad(int(arcs[0]), "it is a part of an arc", "divide arcs into lines")
                )
            trajectory = trajectory.positions, trajectory.quaternions
        positions, quaternions = self._checked(*trajectory)
        if configurations is not None and len(configurations) != len(positions):
            raise Refused(
                _bad(
                    min(len(configurations), len(positions)),
                    f"there are {len(positions)} poses and {len(configurations)} configurations",
                    "state one for each pose, or none",
                )
            )
        for row in range(len(positions)):
            configuration = configurations[row] if configurations is not None else None
            pose = Pose.of(positions[row], quaternions[row])
            answer = self._move(pose, configuration, through)
            if progress is not None:
                progress(row + 1, len(positions), answer)
        return self.recording

    def stop(self) -> Answer | None:
        """Stops the robot where it is and ends its program; None if nothing answered in time.

        May be asked for at any time, also where a request is under way or another process exchanges
        poses: its claim ends. `ended` says afterwards what is known of the robot. Raises Refused if
        the controller could not be told.
        """
        self._number = _next(self._number)
        number = self._number
        self._put("stop", messages.stop_request(number))
        with suppress(Refused):  # what cannot be freed keeps nobody from waiting for the answer
            self._claim.clear()
        end = time.monotonic() + self._timeout
        while time.monotonic() < end:
            data = self._look("stopped")
            answer = None if data is None else messages.parse(data)
            if answer is not None and answer.number == number:
                self.stopped = answer
                self._remove("stopped")
                self.ended = "the robot stands still, and its program has ended"
                return answer
            self._pause()
        for file in ("request", "taken", "stop"):
            self._remove(file)
        self.ended = (
            f"nothing answered to the stop within {self._timeout:g} s: either no program of an "
            "exchange runs on the controller, or the robot may still move"
        )
        return None

    def _move(self, pose: Pose, configuration: Configuration | None, through: bool) -> Answer:
        word: Word = "pass" if through else "move"
        if configuration is not None and not _is_configuration(configuration):
            reason = f"its configuration is {configuration!r:.60}"
            raise Refused(_bad(0, reason, "state four whole numbers: cf1, cf4, cf6, cfx"))
        if not self._in_step or self._number == messages.LARGEST_NUMBER:
            self.current_pose()  # the robot counts from the number of such a request
        return self._ask(word, pose, configuration, self._longest)

    def _ask(
        self, word: Word, pose: Pose | None, configuration: Configuration | None, longest: float
    ) -> Answer:
        """Sends a request and waits for its own answer; others are left alone."""
        if self.ended:
            raise Refused(rules.ENDED(place=str(self.programs.address), reason=self.ended))
        with self._claimed():
            self._number = _next(self._number)
            if not self._in_step:
                self._forget_unread()
            number, began, self._in_step = self._number, time.perf_counter(), False
            self._hand_over(messages.request(number, word, pose, configuration))
            answer = self._answer(number, word, longest, began)
            self._remove("answer")
        if answer.word != "ok":
            self._declined(answer, number, word)
        self.checked = answer.checked
        add(self.recording, time.monotonic() - self._begin, answer, self.spent, pose)
        if pose is not None and word == "move":
            self._compare(answer, pose, configuration)
        self._in_step = True
        return answer

    @contextmanager
    def _claimed(self) -> Iterator[None]:
        """Holds the claim, for one request where it was not taken for all of them."""
        if self._claim.held:
            yield
            return
        self._claim.take()
        try:
            yield
        finally:
            with suppress(Refused):
                self._claim.free()

    def _answer(self, number: int, word: Word, longest: float, began: float) -> Answer:
        """Waits for the answer to a request; raises Refused where none comes."""
        handed, looks, unread, asked_after = time.perf_counter(), 0, 0.0, False
        while True:
            looking, looks = time.perf_counter(), looks + 1
            data = self._look("answer")
            answer = None if data is None else messages.parse(data)
            if answer is not None and messages.is_of(answer, number):
                break
            if self.ended:  # another thread stopped it meanwhile
                raise Refused(rules.ENDED(place=str(self.programs.address), reason=self.ended))
            now = time.perf_counter()
            if answer is not None or data in (None, self._left):
                unread = now
            elif now - (unread or handed) > SETTLE:
                raise Refused(
                    rules.BAD_ANSWER(place=str(self.programs.address), number=number, word=word)
                )
            if now - handed > longest:
                self._unanswered(number, word, longest)
            if now - handed > self._timeout and not asked_after:
                asked_after = True
                self._ask_after(number, word, longest)
            self._pause()
        done = time.perf_counter()
        self.spent = Spent(handed - began, looking - handed, done - looking, answer.motion, looks)
        return answer

    def _ask_after(self, number: int, word: Word, longest: float) -> None:
        """Raises Refused if the program has not taken the request of a motion, or was stopped."""
        self._claim.check()
        if self.checked and not self._is_taken(number):
            data = self._look("answer")
            answer = None if data is None else messages.parse(data)
            if answer is None or not messages.is_of(answer, number):
                self._unanswered(number, word, min(self._timeout, longest))

    def _is_taken(self, number: int) -> bool:
        """True if the program says that it took the request: it has renamed it."""
        data = self._look("taken")
        return data is not None and data.startswith(b"%d\n" % number)

    def _compare(self, answer: Answer, pose: Pose, configuration: Configuration | None) -> None:
        """Raises Refused if a robot that has gone to a pose is not at it."""
        distance = float(np.linalg.norm(np.subtract(answer.pose.position, pose.position)))
        angle = float(rotations.angle_between(answer.pose.quaternion, pose.quaternion))
        quarters = 0
        if configuration is not None:  # at the edge of a quarter the controller tells either
            pairs = zip(answer.configuration[:3], configuration[:3], strict=True)
            quarters = max(abs(one - int(other)) for one, other in pairs)
        if distance <= OFF and angle <= OFF and quarters <= 1:
            return
        off = [f"{distance:.1f} mm and {angle:.1f} degrees"]
        if quarters > 1:
            off.append(f"and by configuration {answer.configuration} instead of {configuration}")
        raise Refused(
            rules.ELSEWHERE(
                place=str(self.programs.address),
                number=self._number,
                distance=" ".join(off),
                stands=_at(answer.pose),
                asked=_at(pose),
            )
        )

    def _forget_unread(self) -> None:
        """Removes an old answer that does not name its request: it would be taken for the next."""
        self._left = self._look("answer")
        answer = None if self._left is None else messages.parse(self._left)
        if answer is not None and answer.number == messages.UNREAD:
            self._remove("answer")
            self._left = None

    def _hand_over(self, data: bytes) -> None:
        """Puts a request there; where that is refused half-way, it is taken back."""
        try:
            self._put("request", data)
        except common.Lost:
            raise
        except Refused as error:
            if self._taken_back() is False and self._look("request") is None:
                error.add_note("the request may have been taken, and the robot may move")
            raise

    def _unanswered(self, number: int, word: Word, seconds: float) -> None:
        """Takes the request back, if it still lies there, so that nothing carries it out later."""
        state = {
            True: "it was not taken and has been removed; it moved nothing",
            False: "it is gone, and the program has not said that it took it: something else may "
            "have removed it; the robot may still move",
            None: "it has been removed; if it was taken in that moment, the robot may still move",
        }[self._taken_back()]
        if self._is_taken(number):
            state = "it was taken, so that the robot may still move"
        raise Refused(
            rules.NO_ANSWER(
                place=str(self.programs.address),
                number=number,
                word=word,
                seconds=seconds,
                state=state,
            )
        )

    def _taken_back(self) -> bool | None:
        """Whether the request could be removed, so that it never is carried out.

        The program carries out what it removes itself: only one of both can. None where the
        client does not tell whether a file was there.
        """
        if isinstance(self.programs, HandsOver):
            return self.programs.take_away(self._names["request"])
        if self._look("request") is None:
            return False
        self._remove("request")
        return None

    def _declined(self, answer: Answer, number: int, word: Word) -> None:
        unknown = f"it answered `{answer.word}`", "look at the event log of the controller"
        reason, cure = rules.REASONS.get(answer.word, unknown)
        still = "it stands" if answer.word != "failed" else "it was"
        raise Refused(
            rules.DECLINED(
                place=str(self.programs.address),
                number=number,
                word=word,
                reason=reason,
                state=f"{still} at {_at(answer.pose)}",
                cure=cure,
            )
        )

    def _stop_after(self, error: BaseException) -> None:
        """Stops; anew connected where the session was lost or left in the midst of a command."""
        try:
            if isinstance(error, common.Lost) or not isinstance(error, Exception):
                self.programs.__exit__(None, None, None)
                self.programs.__enter__()
            self.stop()
        except Refused as refused:
            self.ended = f"the robot could not be told to stop and may still move: {_said(refused)}"
        except BaseException:
            self.ended = "the stop was broken off, and the robot may still move"
            raise
        if isinstance(error, Refused):
            error.add_note(self.ended)

    def _checked(self, positions: ArrayLike, quaternions: ArrayLike) -> tuple[Floats, Floats]:
        """Columns of poses that may be sent; raises Refused for the first that must not."""
        place, turn = _columns(positions, 3), _columns(quaternions, 4)
        if len(place) != len(turn):
            reason = f"there are {len(place)} positions and {len(turn)} quaternions"
            raise Refused(_bad(min(len(place), len(turn)), reason, "state both for each pose"))
        if not len(place):
            return place, turn
        finite = np.isfinite(place).all(axis=1) & np.isfinite(turn).all(axis=1)
        near = (np.abs(place) <= FARTHEST).all(axis=1)
        unit = np.abs(np.sqrt((turn * turn).sum(axis=1)) - 1.0) <= UNIT
        for good, reason, cure in (
            (finite, "it holds a number that is not finite", "correct the number"),
            (near, f"it is farther than {FARTHEST:g} mm away", "state positions in mm"),
            (unit, "its quaternion is not of unit length", "state unit quaternions (w, x, y, z)"),
        ):
            bad = np.flatnonzero(~good)
            if bad.size:
                raise Refused(_bad(int(bad[0]), reason, cure))
        turn = rotations.canonical(turn)
        refused = dict(self._check(place, turn)) if self._check is not None else {}
        if refused:
            row = min(refused)
            more = f" ({len(refused)} poses are refused)" if len(refused) > 1 else ""
            raise Refused(_bad(row, refused[row] + more, "choose a pose that may be sent"))
        return place, turn

    def _put(self, file: str, data: bytes) -> None:
        self._files.put(self._names[file], data)

    def _look(self, file: str) -> bytes | None:
        return self._files.look(self._names[file])

    def _remove(self, file: str) -> None:
        self._files.remove(self._names[file])

    def _pause(self) -> None:
        threading.Event().wait(self._poll)


def _columns(rows: ArrayLike, width: int) -> Floats:
    """Rows of so many numbers; raises Refused for others."""
    try:
        found = reals(rows)
    except ValueError as error:
        raise Refused(_bad(0, f"it is no row of numbers ({error})", _ROWS)) from None
    if found.size == 0:
        return found.reshape(0, width)
    if found.ndim != 2 or found.shape[1] != width:
        raise Refused(_bad(0, f"its columns are of the shape {found.shape}", _ROWS))
    return found


def _is_configuration(given: Sequence[float]) -> bool:
    """Whether these are the four whole numbers of a robtarget."""
    return len(given) == 4 and all(
        isinstance(one, (int, float, np.integer))
        and abs(one) <= LARGEST_CONFIGURATION
        and one == int(one)
        for one in given
    )


def _next(number: int) -> int:
    return number % messages.LARGEST_NUMBER + 1


def _at(pose: Pose) -> str:
    x, y, z = pose.position
    return f"({x:g}, {y:g}, {z:g}) mm"


def _bad(row: int, reason: str, cure: str) -> Diagnostic:
    return rules.BAD_POSE(row=row + 1, reason=reason, cure=cure)


def _said(refused: Refused) -> str:
    return "; ".join(finding.message for finding in refused.findings)

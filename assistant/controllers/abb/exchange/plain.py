"""The PC's side of the plain protocol: three text files with a pose go, three come back.

with controllers.connect("ftp://engineer@192.168.125.1") as programs:
    with PlainExchange(programs) as exchange:
        start = exchange.current_pose()
        exchange.move_to(start.pose.offset(z=-20.0))

The files hold a row of numbers each and no number of their question. So this side takes care that
an answer cannot be of an earlier one: it deletes old files before it asks, and reads no answer
before the program has deleted the question, which the module of `Module(plain=…)` does after it has
deleted its last answer.
"""

from __future__ import annotations

import math
import re
import threading
import time
from collections.abc import Sequence
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules as common
from assistant.controllers.abb.exchange import rules
from assistant.controllers.abb.exchange.claiming import HandsOver
from assistant.controllers.abb.exchange.messages import Answer, Configuration
from assistant.controllers.abb.exchange.module import PlainFiles
from assistant.controllers.abb.exchange.poses import (
    UNREADABLE_AFTER,
    Check,
    PoseSender,
    checked_configuration,
)
from assistant.controllers.abb.exchange.recording import NOT_ASKED, Spent, record_answer
from assistant.controllers.controller import Controller, Programs
from assistant.program.geometry import Pose

LONGEST_PLAIN_FILE: Final = 1000
"""Most bytes of an answer's file."""
Texts = tuple[bytes, bytes, bytes]
"""Position, orientation, configuration."""


class PlainExchange(PoseSender):
    """An exchange with a program that waits for three files of a pose and answers with three.

    A context manager, as `PoseExchange` is. The protocol has no stop: leaving it because of an
    error takes a question back that no program has taken, stops the programs where the session can
    (`rws`), and `ended` says what the robot may still do.

    files: their names, as the program has them. prefix: of the claim. timeout: seconds in which the
    program has to take a question, and to answer one without a motion. longest: seconds for a
    motion.
    """

    def __init__(
        self,
        programs: Programs,
        *,
        files: PlainFiles | None = None,
        prefix: str = "exchange",
        timeout: float = 10.0,
        longest: float = 240.0,
        poll: float = 0.01,
        check: Check | None = None,
    ) -> None:
        super().__init__(programs, prefix, longest, poll, check)
        self._names = files or PlainFiles()
        self._timeout = timeout
        self._number = 0
        self._asked = False
        self._stands = False

    @property
    def stands(self) -> bool:
        return self._stands

    def current_pose(self) -> Answer:
        """Return the pose of the robot: it answers files of an empty line without a motion."""
        return self._ask(None, None, self._timeout)

    def _move(self, pose: Pose, configuration: Configuration | None, through: bool) -> Answer:
        if through:
            reason = "the files of a plain exchange cannot ask for it"
            raise Refused(
                common.NOT_HERE(
                    place=self._place,
                    address=self._place,
                    what="go through a pose without standing still",
                    reason=reason,
                    cure="leave `through` out, or exchange poses by the numbered protocol",
                )
            )
        checked_configuration(configuration)
        return self._ask(pose, configuration, self._longest)

    def _ask(
        self, pose: Pose | None, configuration: Configuration | None, longest: float
    ) -> Answer:
        if self.ended:
            raise Refused(rules.ENDED(place=self._place, reason=self.ended))
        with self._claimed():
            self._number += 1
            self._clear()
            began = time.perf_counter()
            self._hand_over(_plain_question(pose, configuration))
            answer = self._answer("where" if pose is None else "move", longest, began)
            self._asked = False
            for name in self._names.answers:
                self._files.remove(name)
        record_answer(self.recording, time.monotonic() - self._begin, answer, self.spent, pose)
        if pose is not None:
            self._compare(self._number, answer, pose, configuration)
        return answer

    def _there(self) -> set[str]:
        """Files of the exchange on the controller, in lower case as its disk compares names."""
        return {name.lower() for name in self.programs.names()} & {
            name.lower() for name in (*self._names.sent, *self._names.answers)
        }

    def _clear(self) -> None:
        """Deletes what an earlier question or answer left; raises Refused if something stays."""
        names = (*self._names.sent, *self._names.answers)
        left = self._there()
        if not left:
            return
        for name in names:
            if name.lower() in left:
                self._files.remove(name)
        left = self._there()
        stays = next((name for name in names if name.lower() in left), None)
        if stays is not None:
            raise Refused(rules.STALE(place=self._place, name=stays))

    def _hand_over(self, texts: Texts) -> None:
        """Puts the files there, each whole, the first one last; takes them back if one fails."""
        self._asked = True
        try:
            for name, text in reversed(list(zip(self._names.sent, texts, strict=True))):
                self._files.put(name, text)
        except common.Lost:
            raise
        except Refused as error:
            if self._taken_back() is False:
                error.add_note("the robot moves only if all three files had arrived")
            raise

    def _answer(self, word: str, longest: float, began: float) -> Answer:
        """Waits until the question is taken, then for three complete files."""
        handed, looks, unread, taken = time.perf_counter(), 0, 0.0, False
        question = self._names.sent[0].lower()

        while True:
            looking, looks = time.perf_counter(), looks + 1
            there = self._there()
            taken = taken or question not in there
            if taken and there.issuperset(name.lower() for name in self._names.answers):
                texts = [self._files.look(name) or b"" for name in self._names.answers]
                answer = parse_plain_answer(self._number, texts)
                if answer is not None:
                    break
                unread = unread or looking
                if looking - unread > UNREADABLE_AFTER:
                    raise Refused(
                        rules.BAD_ANSWER(place=self._place, number=self._number, word=word)
                    )
            waited = looking - handed
            if not taken and waited > min(self._timeout, longest):
                self._unanswered(word, min(self._timeout, longest))
            if waited > longest:
                self._unanswered(word, longest)
            threading.Event().wait(self._poll)
        done = time.perf_counter()
        self.spent = Spent(handed - began, looking - handed, done - looking, NOT_ASKED, looks)
        return answer

    def _unanswered(self, word: str, seconds: float) -> None:
        name = self._names.sent[0]
        state = f"`{name}` is gone, so that a program has taken it; the robot may still move"
        if self._taken_back() is not False:
            state = (
                f"`{name}` was still there and has been removed; nothing moves, unless a program "
                "had read it before"
            )
        raise Refused(
            rules.NO_ANSWER(
                place=self._place, number=self._number, word=word, seconds=seconds, state=state
            )
        )

    def _taken_back(self) -> bool | None:
        """Removes the question; False if the file that the program waits for was gone.

        None where the client does not report whether a file was there.
        """
        first, *others = self._names.sent
        back: bool | None
        if isinstance(self.programs, HandsOver):
            back = self.programs.take_away(first)
        else:
            back = None if first.lower() in self._there() else False
            self._files.remove(first)
        for name in others:
            self._files.remove(name)
        self._asked = back is False
        return back

    def _halt(self) -> None:
        """Take the question back, and stop the programs if the session can."""
        if self._asked:
            self._taken_back()
        if isinstance(self.programs, Controller):
            self.programs.stop()
            self._stands = True
            self.ended = "the programs of the controller were stopped"
        elif self._asked:
            self.ended = (
                "the plain protocol has no stop: the robot may still move to the last pose; "
                "its program then waits for the next"
            )
        else:
            self._stands = True
            self.ended = "no pose is under way; the program waits for the next"


def _plain_question(pose: Pose | None, configuration: Configuration | None) -> Texts:
    """The three files; an empty line where there is nothing to state."""
    if pose is None:
        return b"\n", b"\n", b"\n"
    configured = b"\n" if configuration is None else _plain_row(configuration, 0)
    return _plain_row(pose.position, 6), _plain_row(pose.quaternion, 9), configured


def _plain_row(values: tuple[float, ...], decimals: int) -> bytes:
    return f"[{','.join(f'{value + 0.0:.{decimals}f}' for value in values)}]\n".encode("ascii")


def parse_plain_answer(number: int, texts: Sequence[bytes]) -> Answer | None:
    """Return the answer in three files; None if one is incomplete or holds something else."""
    rows = [_plain_values(text, count) for text, count in zip(texts, (3, 4, 4), strict=True)]
    place, turn, configuration = rows
    if place is None or turn is None or configuration is None:
        return None
    length = math.hypot(*turn)
    if abs(length - 1.0) > 1e-3 or any(one != int(one) for one in configuration):
        return None
    x, y, z = place
    w, a, b, c = (part / length for part in turn)
    cf1, cf4, cf6, cfx = map(int, configuration)
    axes = (math.nan,) * 6
    pose = Pose((x, y, z), (w, a, b, c))
    return Answer(number, "ok", pose, (cf1, cf4, cf6, cfx), axes, NOT_ASKED)


def _plain_values(text: bytes, count: int) -> tuple[float, ...] | None:
    """`count` finite numbers of a file that ends with a line end: in brackets, or in lines.

    Commas are between numbers: a line with another use of them, as for decimals, is not read.
    """
    if len(text) > LONGEST_PLAIN_FILE or not text.endswith(b"\n"):
        return None
    line = text.decode("latin-1").strip()
    row = re.fullmatch(r"\[(.*)\]", line)
    parts = line.split() if row is None else row[1].split(",")
    if any("_" in part for part in parts):
        return None
    try:
        values = tuple(map(float, parts))
    except ValueError:
        return None
    return values if len(values) == count and all(map(math.isfinite, values)) else None

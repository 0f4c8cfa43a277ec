"""Both protocols of the pose exchange, on the side of the PC: numbered files and plain files.

with controllers.connect("ftp://engineer@192.168.125.1") as programs:
    with PoseExchange(programs) as exchange:
        start = exchange.current_pose()
        exchange.move_to(start.pose.offset(z=-20.0))

`PoseExchange` writes a numbered request and waits for its answer. `PlainExchange` writes three text
files with a row of numbers each, and reads three. They have no request number, so it deletes old
files before it asks, and reads no answer before the program has deleted the question, which the
module of `Module(plain=…)` does after it has deleted its last answer.
"""

from __future__ import annotations

import math
import random
import re
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules as common
from assistant.controllers.abb.exchange import files, rules
from assistant.controllers.abb.exchange.files import Answer, Configuration, HandsOver, Word
from assistant.controllers.abb.exchange.pose_sender import (
    NOT_ASKED,
    UNREADABLE_AFTER,
    Check,
    PoseSender,
    Spent,
    checked_configuration,
    position_text,
    record_answer,
)
from assistant.controllers.abb.exchange.rapid_module import PlainFiles, file_names
from assistant.controllers.controller import Controller, Programs
from assistant.program.geometry import Pose


class PoseExchange(PoseSender):
    """Exchange with a program that `Module` printed and that runs on the controller.

    A context manager: entering claims the exchange, so that no other client sends requests in
    between, and asks for the position of the robot, which the program must answer. Leaving it
    because of an error, or of ^C, stops the robot and ends the program (`stop`); leaving it
    otherwise lets the program wait for the next exchange.

    programs: an open session. prefix: of the files, as in the module. timeout: seconds for an
    answer without a motion, and for one to a stop. longest: seconds for one motion. poll: seconds
    between polls for an answer. check: called before poses are sent.
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
        super().__init__(programs, prefix, longest, poll, check)
        self._names = file_names(prefix)
        self._left: bytes | None = None
        self._timeout = timeout
        # At random: an answer that an earlier exchange left has another number.
        self._number = random.randrange(1, files.LARGEST_NUMBER // 2)  # noqa: S311 - no secret
        self._in_step = False

    @property
    def stands(self) -> bool:
        return self.stopped is not None

    def current_pose(self) -> Answer:
        """Return the position of the robot, once its program looks for a request."""
        return self._ask("where", None, None, self._timeout)

    def stop(self) -> Answer | None:
        """Stop the robot at its position and end its program; None if nothing answered in time.

        May be called at any time, also during a request or while another process exchanges poses:
        its claim ends. Afterwards `ended` states the known condition of the robot. Raises Refused
        if the controller could not be reached.
        """
        self._number = _next_number(self._number)
        number = self._number
        self._put("stop", files.stop_request(number))
        with suppress(Refused):  # what cannot be freed keeps nobody from waiting for the answer
            self._claim.clear()
        end = time.monotonic() + self._timeout
        while time.monotonic() < end:
            data = self._look("stopped")
            answer = None if data is None else files.parse_answer(data)
            if answer is not None and answer.number == number:
                self.stopped = answer
                self._remove("stopped")
                self.ended = "the robot stands still, and its program has ended"
                return answer
            self._pause()
        # Nobody answered: the files would stop or move a program that starts later.
        for file in ("request", "taken", "stop"):
            self._remove(file)
        self.ended = (
            f"nothing answered to the stop within {self._timeout:g} s: either no program of an "
            "exchange runs on the controller, or the robot may still move"
        )
        return None

    def _move(self, pose: Pose, configuration: Configuration | None, through: bool) -> Answer:
        word: Word = "pass" if through else "move"
        checked_configuration(configuration)
        # The program counts from the number of a `where` request, and refuses others as foreign.
        if not self._in_step or self._number == files.LARGEST_NUMBER:
            self.current_pose()  # the robot counts from the number of such a request
        return self._ask(word, pose, configuration, self._longest)

    def _ask(
        self, word: Word, pose: Pose | None, configuration: Configuration | None, longest: float
    ) -> Answer:
        """Sends a request and waits for its own answer; others are left alone."""
        if self.ended:
            raise Refused(rules.ENDED(place=self._place, reason=self.ended))
        with self._claimed():
            self._number = _next_number(self._number)
            if not self._in_step:
                self._forget_unread()
            # Out of step until the answer is there: an error in between leaves the count unknown.
            number, began, self._in_step = self._number, time.perf_counter(), False
            self._hand_over(files.request_file(number, word, pose, configuration))
            answer = self._answer(number, word, longest, began)
            self._remove("answer")
        if answer.word != "ok":
            self._declined(answer, number, word)
        self.checked = answer.checked
        record_answer(self.recording, time.monotonic() - self._begin, answer, self.spent, pose)
        if pose is not None and word == "move":
            self._compare(number, answer, pose, configuration)
        self._in_step = True
        return answer

    def _answer(self, number: int, word: Word, longest: float, began: float) -> Answer:
        """Waits for the answer to a request; raises Refused where none comes."""
        handed, looks, unread, asked_after = time.perf_counter(), 0, 0.0, False
        while True:
            looking, looks = time.perf_counter(), looks + 1
            data = self._look("answer")
            answer = None if data is None else files.parse_answer(data)
            if answer is not None and files.is_of(answer, number):
                break
            if self.ended:  # another thread stopped it meanwhile
                raise Refused(rules.ENDED(place=self._place, reason=self.ended))
            now = time.perf_counter()
            # A file that is still being written, or the old one, is no damaged answer.
            if answer is not None or data in (None, self._left):
                unread = now
            elif now - (unread or handed) > UNREADABLE_AFTER:
                raise Refused(rules.BAD_ANSWER(place=self._place, number=number, word=word))
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
        # Modules without checksums do not rename the requests that they take.
        if self.checked and not self._is_taken(number):
            data = self._look("answer")
            answer = None if data is None else files.parse_answer(data)
            if answer is None or not files.is_of(answer, number):
                self._unanswered(number, word, min(self._timeout, longest))

    def _is_taken(self, number: int) -> bool:
        """True if the program says that it took the request: it has renamed it."""
        data = self._look("taken")
        return data is not None and data.startswith(b"%d\n" % number)

    def _forget_unread(self) -> None:
        """Removes an old answer that does not name its request: it would be taken for the next."""
        self._left = self._look("answer")
        answer = None if self._left is None else files.parse_answer(self._left)
        if answer is not None and answer.number == files.UNREAD:
            self._remove("answer")
            self._left = None

    def _hand_over(self, data: bytes) -> None:
        """Write a request; withdraw it if the write is refused half-way."""
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
                place=self._place,
                number=number,
                word=word,
                seconds=seconds,
                state=state,
            )
        )

    def _taken_back(self) -> bool | None:
        """True if the request was removed, so that it is never executed.

        The program executes a request that it removes itself: only one of both can remove it. None
        where the client does not report whether the file existed.
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
                place=self._place,
                number=number,
                word=word,
                reason=reason,
                state=f"{still} at {position_text(answer.pose)}",
                cure=cure,
            )
        )

    def _halt(self) -> None:
        self.stop()

    def _put(self, file: str, data: bytes) -> None:
        self._files.put(self._names[file], data)

    def _look(self, file: str) -> bytes | None:
        return self._files.look(self._names[file])

    def _remove(self, file: str) -> None:
        self._files.remove(self._names[file])

    def _pause(self) -> None:
        threading.Event().wait(self._poll)


def _next_number(number: int) -> int:
    return number % files.LARGEST_NUMBER + 1


_LONGEST_PLAIN_FILE: Final = 1000
"""Most bytes of an answer's file."""
_Texts = tuple[bytes, bytes, bytes]
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
            # Requests have no numbers: an old answer would pass for the new one.
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

    def _hand_over(self, texts: _Texts) -> None:
        """Puts the files there, each whole, the first one last; takes them back if one fails."""
        self._asked = True
        try:
            # The first file last: some programs wait for that one only.
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
            # Once gone it stays taken: a program may be writing its own files of that name.
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


def _plain_question(pose: Pose | None, configuration: Configuration | None) -> _Texts:
    """The three files; an empty line where there is nothing to state."""
    if pose is None:
        return b"\n", b"\n", b"\n"
    configured = b"\n" if configuration is None else _plain_row(configuration, 0)
    return _plain_row(pose.position, 6), _plain_row(pose.quaternion, 9), configured


def _plain_row(values: tuple[float, ...], decimals: int) -> bytes:
    # + 0.0 turns -0.0 into 0.0.
    return f"[{','.join(f'{value + 0.0:.{decimals}f}' for value in values)}]\n".encode("ascii")


def parse_plain_answer(number: int, texts: Sequence[bytes]) -> Answer | None:
    """Return the answer in three files; None if one is incomplete or holds something else."""
    rows = [_plain_values(text, count) for text, count in zip(texts, (3, 4, 4), strict=True)]
    place, turn, configuration = rows
    if place is None or turn is None or configuration is None:
        return None
    length = math.hypot(*turn)
    # A quaternion far from unit length, or a broken configuration, is half a file.
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
    if len(text) > _LONGEST_PLAIN_FILE or not text.endswith(b"\n"):
        return None
    line = text.decode("latin-1").strip()
    row = re.fullmatch(r"\[(.*)\]", line)
    parts = line.split() if row is None else row[1].split(",")
    # float() accepts `1_0`, which no controller writes.
    if any("_" in part for part in parts):
        return None
    try:
        values = tuple(map(float, parts))
    except ValueError:
        return None
    return values if len(values) == count and all(map(math.isfinite, values)) else None

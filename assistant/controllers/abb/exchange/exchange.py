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
from contextlib import suppress

from assistant.base.diagnostics import Refused
from assistant.controllers import rules as common
from assistant.controllers.abb.exchange import messages, rules
from assistant.controllers.abb.exchange.claiming import HandsOver
from assistant.controllers.abb.exchange.messages import Answer, Configuration, Word
from assistant.controllers.abb.exchange.module import file_names
from assistant.controllers.abb.exchange.poses import (
    UNREADABLE_AFTER,
    Check,
    PoseSender,
    checked_configuration,
    position_text,
)
from assistant.controllers.abb.exchange.recording import Spent, record_answer
from assistant.controllers.controller import Programs
from assistant.program.geometry import Pose


class PoseExchange(PoseSender):
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
        super().__init__(programs, prefix, longest, poll, check)
        self._names = file_names(prefix)
        self._left: bytes | None = None
        self._timeout = timeout
        self._number = random.randrange(1, messages.LARGEST_NUMBER // 2)  # noqa: S311 - no secret
        self._in_step = False

    @property
    def stands(self) -> bool:
        return self.stopped is not None

    def current_pose(self) -> Answer:
        """Where the robot is, once its program has come to look for a request."""
        return self._ask("where", None, None, self._timeout)

    def stop(self) -> Answer | None:
        """Stops the robot where it is and ends its program; None if nothing answered in time.

        May be asked for at any time, also where a request is under way or another process exchanges
        poses: its claim ends. `ended` says afterwards what is known of the robot. Raises Refused if
        the controller could not be told.
        """
        self._number = _next_number(self._number)
        number = self._number
        self._put("stop", messages.stop_request(number))
        with suppress(Refused):  # what cannot be freed keeps nobody from waiting for the answer
            self._claim.clear()
        end = time.monotonic() + self._timeout
        while time.monotonic() < end:
            data = self._look("stopped")
            answer = None if data is None else messages.parse_answer(data)
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
        checked_configuration(configuration)
        if not self._in_step or self._number == messages.LARGEST_NUMBER:
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
            number, began, self._in_step = self._number, time.perf_counter(), False
            self._hand_over(messages.request_file(number, word, pose, configuration))
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
            answer = None if data is None else messages.parse_answer(data)
            if answer is not None and messages.is_of(answer, number):
                break
            if self.ended:  # another thread stopped it meanwhile
                raise Refused(rules.ENDED(place=self._place, reason=self.ended))
            now = time.perf_counter()
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
        if self.checked and not self._is_taken(number):
            data = self._look("answer")
            answer = None if data is None else messages.parse_answer(data)
            if answer is None or not messages.is_of(answer, number):
                self._unanswered(number, word, min(self._timeout, longest))

    def _is_taken(self, number: int) -> bool:
        """True if the program says that it took the request: it has renamed it."""
        data = self._look("taken")
        return data is not None and data.startswith(b"%d\n" % number)

    def _forget_unread(self) -> None:
        """Removes an old answer that does not name its request: it would be taken for the next."""
        self._left = self._look("answer")
        answer = None if self._left is None else messages.parse_answer(self._left)
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
                place=self._place,
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
    return number % messages.LARGEST_NUMBER + 1

"""A proxy that stays, and meddles with each conversation in the way that it is told.

with Meddler(controller.port) as proxy:
    proxy.arm(step=7, answer=b"550 no\r\n")   # instead of passing the eighth command on
"""

import os
import signal
import time

from tests.controllers.abb.cutting_ftp import CuttingFtp


class Meddler(CuttingFtp):
    """For one conversation after the other; also for what is no FTP.

    `steps` counts the pieces that clients sent on connections other than those of transfers,
    `marks` holds how many bytes had passed at the end of each piece of both ways.
    """

    def __init__(self, port):
        super().__init__(port)
        self._of_transfers = set()
        self._clear()

    def _clear(self):
        self._cut, self.passed, self._again, self._told = None, 0, True, False
        self.steps, self.marks = 0, []
        self._step = self._answer = self._pid = None
        self._behind, self._act = False, None

    def serve(self, port):
        """Another controller takes the place of the one behind it."""
        self._control = self._target = ("127.0.0.1", port)

    def arm(
        self, *, cut=None, again=True, step=None, answer=None, pid=None, behind=False, act=None
    ):  # fmt: skip
        """What is to happen next.

        cut: bytes after which every connection is cut; again: whether new ones come through then.
        step: number of a piece of clients (from 0, transfers count as well where pid is given)
        where it happens: answer comes instead of it, or the process of that number is killed,
        before the piece is passed on or (behind) before its answer is. act: is called
        with the number of each piece of clients before it is passed on.
        """
        self.calm()
        self._clear()
        self._transfers.clear()
        self.was_cut.clear()
        self._again, self._step, self._answer, self._pid = again, step, answer, pid
        self._behind, self._cut, self._act = behind, cut, act

    def calm(self):
        """Waits until every connection is closed; the next one comes through."""
        end = time.monotonic() + 10
        while self._other and time.monotonic() < end:
            time.sleep(0.002)
        assert not self._other
        self._again = True

    def _accept(self):
        transfer = bool(self._transfers)
        before = set(self._of_controller)
        super()._accept()
        if transfer:
            self._of_transfers |= self._of_controller - before

    def _pass_on(self, to, data):
        if to in self._of_controller:
            if not self._met(to, data):
                return
        elif self._kills_at(self.steps - 1) and self._behind:
            self._kill()
            return
        super()._pass_on(to, data)
        self.marks.append(self.passed)

    def _met(self, to, data):
        """Whether a piece of a client goes on to the controller."""
        transfer = to in self._of_transfers
        number = self.steps
        if not transfer or self._pid is not None:
            self.steps += 1
        if self._act is not None:
            self._act(number)
        if self._step != number or (transfer and self._pid is None):
            return True
        if self._answer is not None:
            back = self._other[to]
            back.sendall(self._answer)
            return False
        if self._kills_at(number) and not self._behind:
            self._kill()
            return False
        return True

    def _kills_at(self, number):
        return self._pid is not None and self._step == number

    def _kill(self):
        pid, self._pid = self._pid, None
        os.kill(pid, signal.SIGKILL)
        self._cut_all()

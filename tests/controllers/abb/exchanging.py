"""A robot that exchanges poses: the printed module run by the interpreter, beside a file server."""

import threading

import numpy as np

from assistant import languages, robots
from assistant.base import rotations
from assistant.controllers import connect
from assistant.controllers.abb.exchange import Module, PlainFiles, Tool
from assistant.virtual.events import Moved
from assistant.virtual.irc5 import VirtualIrc5
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.rapid import TaskProgram, run_tasks
from assistant.virtual.rapid.controller import Controller
from assistant.virtual.rapid.disk import Disk

ROBOT = "irb1200-7-0.7"
TOOL = Tool((0.0, 0.0, 118.0), mass=0.9, centre=(0.0, 0.0, 52.0))
MODULE = Module(tool="GRIPPER", tool_data=TOOL, longest=60.0)
START = "MoveJ [[420,60,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,fine,{tool};"
"""So that no axis is at the edge of its quadrant, as they are at home."""


POSES = 35


def moves(robot):
    """The linear motions of the robot; the first motion is that to its start."""
    return [event for event in robot.run.events if isinstance(event, Moved)][1:]


def targets(start, number=POSES):
    """Poses from the start to 120 mm beside and 40 mm below, turned by 20 degrees."""
    parts = np.arange(1, number + 1) / number
    ends = rotations.multiply(start.quaternion, rotations.about([0.0, 0.0, 1.0], 20.0))
    places = np.asarray(start.position) + parts[:, None] * np.array([0.0, 120.0, -40.0])
    return places, rotations.between(np.asarray(start.quaternion), ends, parts)


class Robot:
    """A module that the interpreter runs in a thread.

    tree: of the module. home: its disk. pace: simulated seconds in a real one, None for as fast as
    it goes. run: what it did, None before its end.
    """

    def __init__(self, tree, home, pace):
        assert not tree.findings
        self.tree, self.home, self.pace = tree, home, pace
        self.run = None
        self.thread = threading.Thread(target=self._runs, name="robot", daemon=True)

    def _begin(self, left):
        """Starts the program, and waits until it has removed an old file, the last of all."""
        left.touch()
        self.thread.start()
        for _ in range(4000):
            if not left.exists():
                return
            threading.Event().wait(0.005)
        raise AssertionError(f"the program does not start: {self.run}")

    def _runs(self):
        robot = robots.get(ROBOT)
        self.run = run_tasks(
            [TaskProgram(name="T_ROB1", modules=[self.tree])],
            robot=robot,
            motion=Timed(robot),
            pace=self.pace,
            most_time=600.0,
            controller=Controller(disk=Disk(self.home, outside=True)),
        )


class RunningRobot(Robot):
    """A context manager.

    pace: simulated seconds in a real one, None for as fast as it goes. begins: whether its program
    runs. rws: port of Robot Web Services beside FTP, None for none.
    """

    def __init__(self, folder, module=MODULE, *, pace=None, begins=True, rws=None):
        self.controller = VirtualIrc5(folder, rws=rws, rwss=None)
        text = module.text()
        before, loop, behind = text.partition("        WHILE NOT bNobody DO\n")
        start = f"        {START.format(tool=module.tool)}\n"
        tree = languages.get("rapid").parse(before + start + loop + behind)
        super().__init__(tree, self.controller.folder, pace)
        self.begins = begins

    def __enter__(self):
        self.controller.start()
        if self.begins:
            self.begin()
        return self

    def begin(self):
        """Starts its program, and waits until that has cleared away what was left there."""
        self._begin(self.home / "exchange_stopped.txt")

    def __exit__(self, *error):
        if self.thread.is_alive():
            (self.controller.folder / "exchange_stop.txt").write_text("1\nEND 1\n")
            self.thread.join(20)
        self.controller.stop()
        assert not self.thread.is_alive()

    def client(self, port=None, timeout=5.0):
        address = f"ftp://{self.controller.user}@127.0.0.1:{port or self.controller.port}"
        return connect(address, password=self.controller.password, timeout=timeout)

    def ended(self):
        """How its program ended."""
        self.thread.join(20)
        return self.run.ended, self.run.message


PLAIN = Module(tool="GRIPPER", tool_data=TOOL, longest=60.0, plain=PlainFiles())


class PlainRobot(Robot):
    """A robot whose program exchanges plain files in a folder, which any server may serve.

    text: of its module. begins: whether its program runs. files, folder: of the module.
    """

    def __init__(self, home, text=None, *, begins=True, files=None, folder=""):
        self.begins = begins
        self.files, self.folder = files or PlainFiles(), home / folder
        text = PLAIN.text() if text is None else text
        before, loop, after = text.partition("        WHILE TRUE DO\n")
        assert loop
        start = f"        {START.format(tool='GRIPPER')}\n"
        loop = '        WHILE NOT IsFile("HOME:/end.txt") DO\n'
        tree = languages.get("rapid").parse(before + start + loop + after)
        super().__init__(tree, home, None)

    def __enter__(self):
        if self.begins:
            self.begin()
        return self

    def begin(self):
        """Starts its program, and waits until that has deleted what was left there."""
        self._begin(self.folder / self.files.answers[0])

    def __exit__(self, *error):
        if not self.thread.ident:
            return
        self.end()
        assert not self.thread.is_alive()

    def end(self):
        """Has its program end, and returns how it did."""
        if self.thread.is_alive():
            (self.home / "end.txt").touch()
            for name in reversed(self.files.sent):
                (self.folder / name).touch()  # an empty file asks, too
        self.thread.join(20)
        for file in self.home.rglob("*.txt"):
            file.unlink()
        return self.run.ended, self.run.message

"""EGM out of RAPID programs, run by the interpreter, with the client at the other end."""

import re
import socket
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assistant import languages, robots
from assistant.controllers.abb.egm import Egm
from assistant.controllers.cyclic import Endpoint, Limits, Settings, Trajectory, resampled
from assistant.controllers.cyclic.loop import Job, Loop, PacketSocket, Stop
from assistant.virtual.events import Moved, Said
from assistant.virtual.irc5.egm_instructions import abilities
from assistant.virtual.kernel import Board, Kernel
from assistant.virtual.kernel.kernel import Instant
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.rapid.interpreter import start_task
from tests.controllers.abb.test_egm import free_port

RAPID = languages.get("rapid")
ROBOT = robots.get("irb1200-7-0.7")
GUIDED = (Path(__file__).parents[3] / "samples" / "rapid" / "guided.mod").read_text()
START = (0.0, 10.0, -20.0, 0.0, 30.0, 0.0)
QUICK = Settings(opening=20.0, settle=0.2, timeout=0.4, softness=1.0, real_time=False, wait="block")


def ran(text, port, motion=None):
    """A run in this thread, whose device sends to a port of this computer."""
    tree = RAPID.parse(text)
    assert tree.findings == ()
    kernel = Kernel(Board(), motion=motion or Instant(), most_time=60.0)
    given = abilities({"UCdevice": ("127.0.0.1", port)})
    start_task(kernel, [tree], robot=ROBOT, abilities=given)
    return kernel.run()


def led(port, trajectory, limits, settings):
    link = Egm(trajectory.kind, trajectory.rows.shape[1])
    speeds, rises = limits.columns(trajectory.kind, trajectory.rows.shape[1])
    rows = resampled(trajectory, limits, link.cycle)
    job = Job(trajectory.kind, rows, tuple(speeds), tuple(rises), settings)
    with PacketSocket(Endpoint("127.0.0.1", 0, "", port)) as wire:
        return Loop(link, wire, job, Stop(), lambda *_: None).run("here")


def both(text, trajectory, limits, motion=None, settings=QUICK):
    port = free_port()
    with ThreadPoolExecutor() as pool:
        run = pool.submit(ran, text, port, motion)
        done = led(port, trajectory, limits, settings)
        return done, run.result()


def joints_of(run):
    return [event.joints for event in run.events if isinstance(event, Moved)]


@pytest.mark.parametrize("timed", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_the_sample_is_guided_until_the_pc_falls_silent(timed):
    motion = Timed(ROBOT, joints=START) if timed else None
    goal = (4.0, 12.0, -18.0, 0.0, 30.0, 0.0)
    limits = Limits((100.0,) * 6, (800.0,) * 6)
    way = Trajectory.of_joints([START, goal], unit="deg")
    text = GUIDED.replace("CommTimeout:=1", "CommTimeout:=0.7")
    done, run = both(text, way, limits, motion)
    assert done.code == "" and done.done == len(resampled(way, limits, 0.004))
    assert run.ended == "end", run.message
    assert [event.text for event in run.events if isinstance(event, Said)] == ["The PC has ended"]
    assert np.allclose(joints_of(run)[-1], goal, atol=0.01)
    assert done.samples[-1][2:8] == pytest.approx(goal, abs=0.05)
    if motion is not None:
        assert motion.where()[1] == pytest.approx(joints_of(run)[-1])


POSES = """MODULE Led
    CONST pose peNone:=[[0,0,0],[1,0,0,0]];
    CONST egm_minmax egmNear:=[-0.05,0.05];
    CONST robtarget pStart:=[[450,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR egmident egmArm;

    PROC main()
        MoveJ pStart,v100,fine,tool0;
        EGMGetId egmArm;
        EGMSetupUC ROB_1,egmArm,"default","UCdevice"\\Pose;
        EGMActPose egmArm\\Tool:=tool0\\WObj:=wobj0,peNone,EGM_FRAME_WOBJ,peNone,EGM_FRAME_WOBJ
            \\x:=egmNear\\y:=egmNear\\z:=egmNear;
        EGMRunPose egmArm,EGM_STOP_HOLD\\x\\y\\z\\rx\\ry\\rz\\CondTime:=0.4;
        EGMStop egmArm,EGM_STOP_HOLD;
        EGMReset egmArm;
    ENDPROC
ENDMODULE
"""


def test_a_tool_is_led_from_a_program():
    turn = (0.0, 0.0, 1.0, 0.0)
    way = Trajectory.of_poses([(450, 0, 500), (456, 3, 500)], [turn, turn])
    held = replace(QUICK, settle=20.0)  # until the controller ends it
    done, run = both(POSES, way, Limits((250.0, 90.0), (2500.0, 900.0)), settings=held)
    assert done.code in ("", "CN712", "CN713")  # it may end before the last point was held
    assert run.ended == "end", run.message
    flange = [event.flange for event in run.events if isinstance(event, Moved)][-1]
    assert flange.position == pytest.approx((456, 3, 500), abs=0.06)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"UCdevice:"', '"other"', "no UdpUc device `other`"),
        ("EGMGetId egmArm;", "", "that EGMGetId did not give"),
        ("EGM_STOP_HOLD", "EGM_STOP_RAMP_DOWN", "goes back to where it began"),
        ("PosCorrGain:=1", "PosCorrGain:=0", "controls the speed"),
        ("EGMRunJoint egmArm,EGM_STOP_HOLD", "EGMRunPose egmArm,EGM_STOP_HOLD", "not"),
        ("\\Joint\\", "\\Pose\\", "did not set up"),
    ],
)
def test_what_is_wrong_or_not_simulated_is_said(old, new, said):
    assert old in GUIDED
    text = GUIDED.replace(old, new)
    if "RunPose" in new:
        text = text.replace("\\J1\\J2\\J3\\J4\\J5\\J6\\CondTime", "\\x\\y\\CondTime")
    run = ran(text, free_port())
    assert run.ended in ("error", "unknown") and said in run.message


def test_without_a_pc_the_program_hears_of_the_time_out():
    text = GUIDED.replace("CommTimeout:=1", "CommTimeout:=0.1").replace("ERR_UDPUC_COMM", "ERR_X")
    text = text.replace("ERROR\n        IF ERRNO=ERR_X THEN", "ERROR\n        IF ERRNO=3 THEN")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as deaf:
        deaf.bind(("127.0.0.1", 0))
        run = ran(text, deaf.getsockname()[1])
    assert run.ended == "error" and "41822" in run.message


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell the sender")
def test_only_the_device_is_heard():
    """A stranger that finds the port of the controller is told that nobody listens there."""
    port = free_port()
    text = re.sub(r"\\CommTimeout:=[\d.]+", r"\\CommTimeout:=0.1", GUIDED)
    with ThreadPoolExecutor() as pool, socket.socket(type=socket.SOCK_DGRAM) as device:
        device.bind(("127.0.0.1", port))
        device.settimeout(20)
        run = pool.submit(ran, text, port)
        _, controller = device.recvfrom(2048)
        with socket.socket(type=socket.SOCK_DGRAM) as stranger:
            stranger.settimeout(5)
            stranger.connect(controller)
            stranger.send(b"move")
            with pytest.raises(ConnectionRefusedError):
                stranger.recv(2048)
        assert any(isinstance(event, Said) for event in run.result().events)

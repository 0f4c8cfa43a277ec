"""Blocks for bdsim around an arm: setpoints of each cycle, signals, cameras, bodies.

sim = BDSim(packages="assistant")
bd = sim.blockdiagram()
cell = by_mxt("cell", "melfa://192.168.0.20", robot)
arm = bd.EXTERNALCONTROL(bd.clock(0.0071), cell, robot)

They are the blocks of `assistant.blocks.library`, whose docstrings describe their ports. Blocks
that move an arm or a gripper run as those of `assistant.blocks.robot`.
"""

from __future__ import annotations

from bdsim.block import FunctionBlock, SampledBlock

from assistant.blocks.bdsim_adapter import Direct, OfKind, Stepped
from assistant.blocks.library import controller_io, external_control, sensors


class ExternalControl(OfKind, Stepped, SampledBlock):
    """wanted joints, enable → joints, commanded joints, limited, cycles, late, worst, jitter.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `by_egm` or `by_mxt`
    :type connection: Connection
    :param robot: the arm that is led
    :type robot: Robot
    :param approach: degrees or mm that the first setpoint may be away
    :type approach: float
    """

    kind = external_control.ExternalControl
    called = "external"
    nin = 2
    nout = 7
    inlabels = ("q", "go")
    outlabels = ("q", "cmd", "!", "n", "n+", "max", "jit")


class ExchangedPose(OfKind, Stepped, SampledBlock):
    """pose, start → busy, poses reached, pose where it stands, seconds of the last motion.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `exchanged`
    :type connection: Connection
    """

    kind = controller_io.ExchangedPose
    called = "exchange"
    nin = 2
    nout = 4
    inlabels = ("T", "go")
    outlabels = ("b", "n", "T", "s")


class InputSignals(OfKind, Stepped, SampledBlock):
    """Inputs of a controller → values, age in seconds.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `asked`
    :type connection: Connection
    :param names: of the inputs
    :type names: list
    """

    kind = controller_io.Signals
    called = "inputs"
    nin = 0
    nout = 2
    outlabels = ("y", "s")


class OutputSignal(OfKind, Stepped, SampledBlock):
    """value → what the output was set to.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `asked`
    :type connection: Connection
    :param output: its name
    :type output: str
    """

    kind = controller_io.Output
    called = "output"
    nin = 1
    nout = 1
    inlabels = ("y",)
    outlabels = ("y",)


class Gripper(OfKind, Stepped, SampledBlock):
    """close → state, confirmed, busy.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `asked`
    :type connection: Connection
    :param by: a `Hand` or a `Valve`
    :type by: Actuated
    :param opened: input that is 1 when it is open
    :type opened: str
    :param closed: input that is 1 when it is closed
    :type closed: str
    :param within: seconds in which it has to confirm
    :type within: float
    """

    kind = controller_io.Gripper
    called = "gripper"
    nin = 1
    nout = 3
    inlabels = ("cl",)
    outlabels = ("y", "ok", "b")


class ProjectedMarker(OfKind, Direct, FunctionBlock):
    """pose of a thing (and of the camera's carrier) → pixels of its points, seen.

    :param camera: that sees it
    :type camera: Camera
    :param thing: that is seen
    :type thing: Thing
    :param noise: pixels, one sigma
    :type noise: float
    :param seed: of the noise
    :type seed: int
    """

    kind = sensors.ProjectedMarker
    called = "camera"
    nin = 1
    nout = 2
    outlabels = ("px", "ok")


class SeenMarker(OfKind, Stepped, SampledBlock):
    """Pictures of a camera → pixels of the points of an object, seen, number of the picture.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param camera: the camera that sees the object
    :type camera: Camera
    :param thing: the object to find
    :type thing: Thing
    :param source: source of the pictures
    :type source: str
    :param rate: pictures a second of files
    :type rate: float
    """

    kind = sensors.SeenMarker
    called = "camera"
    nin = 0
    nout = 3
    outlabels = ("px", "ok", "n")


class PointingDevice(OfKind, Stepped, SampledBlock):
    """Cameras → pose that a device shows, confidence, seen.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param rig: the cameras and their sources
    :type rig: Rig
    :param device: that is followed
    :type device: Device
    :param rate: pictures a second of files
    :type rate: float
    """

    kind = sensors.PointingDevice
    called = "device"
    nin = 0
    nout = 3
    outlabels = ("T", "p", "ok")


class CollisionDistance(OfKind, Direct, FunctionBlock):
    """joints of robots → the least distance of any two bodies of a cell in mm.

    :param cell: a scene, or its file
    :type cell: str
    :param robots: names of those that have an input
    :type robots: list
    """

    kind = sensors.CollisionDistance
    called = "distance"
    nin = 1
    nout = 1
    outlabels = ("mm",)

"""Blocks for bdsim about what is around an arm: setpoints of each cycle, signals, cameras, bodies.

sim = BDSim(packages="assistant")
bd = sim.blockdiagram()
cell = by_mxt("cell", "melfa://192.168.0.20", robot)
arm = bd.EXTERNALCONTROL(bd.clock(0.0071), cell, robot)

They are those of `assistant.blocks.library`, whose docstrings tell of their ports. What moves an
arm or a gripper runs as those of `assistant.blocks.robot`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

from bdsim.block import FunctionBlock, SampledBlock
from bdsim.components import Clock

from assistant.blocks.asking import Asked
from assistant.blocks.connections import Connection
from assistant.blocks.library import clearance, external_control, pose_exchange, seeing, signals
from assistant.blocks.library.adapted import Direct, Stepped
from assistant.cell.scene import Scene
from assistant.controllers.abb.exchange import PoseExchange
from assistant.controllers.controller import Controller
from assistant.robots.robot import Robot
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.pointing.devices import Device
from assistant.vision.pointing.moments import RATE
from assistant.vision.servoing.things import Thing

Cell = Connection[Asked[Controller]]


class ExternalControl(Stepped, SampledBlock):
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

    nin = 2
    nout = 7
    inlabels = ("q", "go")
    outlabels = ("q", "cmd", "!", "n", "n+", "max", "jit")

    def __init__(
        self,
        clock: Clock,
        connection: Connection[external_control.Led],
        robot: Robot,
        *,
        name: str = "external",
        approach: float = external_control.APPROACH,
        **blockargs: Any,
    ) -> None:
        inner = external_control.ExternalControl(name, connection, robot, approach=approach)
        super().__init__(inner, clock, **blockargs)


class ExchangedPose(Stepped, SampledBlock):
    """pose, start → busy, poses reached, pose where it stands, seconds of the last motion.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `exchanged`
    :type connection: Connection
    """

    nin = 2
    nout = 4
    inlabels = ("T", "go")
    outlabels = ("b", "n", "T", "s")

    def __init__(
        self,
        clock: Clock,
        connection: Connection[Asked[PoseExchange]],
        name: str = "exchange",
        **blockargs: Any,
    ) -> None:
        super().__init__(pose_exchange.ExchangedPose(name, connection), clock, **blockargs)


class InputSignals(Stepped, SampledBlock):
    """Inputs of a controller → values, age in seconds.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `asked`
    :type connection: Connection
    :param names: of the inputs
    :type names: list
    """

    nin = 0
    nout = 2
    outlabels = ("y", "s")

    def __init__(
        self,
        clock: Clock,
        connection: Cell,
        names: Sequence[str],
        name: str = "inputs",
        **blockargs: Any,
    ) -> None:
        super().__init__(signals.Signals(name, connection, names), clock, **blockargs)


class OutputSignal(Stepped, SampledBlock):
    """value → what the output was set to.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `asked`
    :type connection: Connection
    :param output: its name
    :type output: str
    """

    nin = 1
    nout = 1
    inlabels = ("y",)
    outlabels = ("y",)

    def __init__(
        self, clock: Clock, connection: Cell, output: str, name: str = "output", **blockargs: Any
    ) -> None:
        super().__init__(signals.Output(name, connection, output), clock, **blockargs)


class Gripper(Stepped, SampledBlock):
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

    nin = 1
    nout = 3
    inlabels = ("cl",)
    outlabels = ("y", "ok", "b")

    def __init__(
        self,
        clock: Clock,
        connection: Cell,
        by: signals.Actuated,
        *,
        name: str = "gripper",
        opened: str | None = None,
        closed: str | None = None,
        within: float = signals.WITHIN,
        **blockargs: Any,
    ) -> None:
        inner = signals.Gripper(name, connection, by, opened=opened, closed=closed, within=within)
        super().__init__(inner, clock, **blockargs)


class ProjectedMarker(Direct, FunctionBlock):
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

    nin = 1
    nout = 2
    outlabels = ("px", "ok")

    def __init__(
        self,
        camera: Camera,
        thing: Thing,
        *,
        name: str = "camera",
        noise: float = 0.0,
        seed: int = seeing.SEED,
        **blockargs: Any,
    ) -> None:
        inner = seeing.ProjectedMarker(name, camera, thing, noise=noise, seed=seed)
        super().__init__(inner, **blockargs)


class SeenMarker(Stepped, SampledBlock):
    """Pictures of a camera → pixels of the points of a thing, seen, number of the picture.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param camera: that sees it
    :type camera: Camera
    :param thing: that is looked for
    :type thing: Thing
    :param source: where its pictures come from
    :type source: str
    :param rate: pictures a second of files
    :type rate: float
    """

    nin = 0
    nout = 3
    outlabels = ("px", "ok", "n")

    def __init__(
        self,
        clock: Clock,
        camera: Camera,
        thing: Thing,
        source: str,
        *,
        name: str = "camera",
        folder: FilePath = FilePath(),
        rate: float = RATE,
        **blockargs: Any,
    ) -> None:
        inner = seeing.SeenMarker(name, camera, thing, source, folder=folder, rate=rate)
        super().__init__(inner, clock, **blockargs)


class PointingDevice(Stepped, SampledBlock):
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

    nin = 0
    nout = 3
    outlabels = ("T", "p", "ok")

    def __init__(
        self,
        clock: Clock,
        rig: Rig,
        device: Device,
        *,
        name: str = "device",
        rate: float = RATE,
        **blockargs: Any,
    ) -> None:
        super().__init__(seeing.PointingDevice(name, rig, device, rate=rate), clock, **blockargs)


class CollisionDistance(Direct, FunctionBlock):
    """joints of robots → the least distance of any two bodies of a cell in mm.

    :param cell: a scene, or its file
    :type cell: str
    :param robots: names of those that have an input
    :type robots: list
    """

    nin = 1
    nout = 1
    outlabels = ("mm",)

    def __init__(
        self,
        cell: Scene | str | FilePath,
        robots: Sequence[str] | None = None,
        name: str = "distance",
        **blockargs: Any,
    ) -> None:
        super().__init__(clearance.CollisionDistance(name, cell, robots), **blockargs)

"""A programming-assistant compiler for industrial robots.

compiled = assistant.compile("part.dxf", language="rapid", robot="irb1200-7-0.7")
compiled.write("out")
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import draw_by, listed, offered

__version__ = "0.1.0"

if TYPE_CHECKING:
    from assistant import deploy, languages, robots
    from assistant.api.analysis import check, simulate
    from assistant.api.arrays import from_joints, from_poses
    from assistant.base.cluster import on
    from assistant.base.diagnostics import Refused
    from assistant.cell.cell_file import read_scene
    from assistant.cell.planning.planner import plan
    from assistant.compiler import Proving, compare, compile, load, translate
    from assistant.controllers import connect
    from assistant.languages import pose_conventions as pose
    from assistant.program.geometry import Frame, Load, Pose, Tool

_LAZY: Final = {
    "Frame": ("assistant.program.geometry", "Frame"),
    "Load": ("assistant.program.geometry", "Load"),
    "Pose": ("assistant.program.geometry", "Pose"),
    "Proving": ("assistant.compiler", "Proving"),
    "Refused": ("assistant.base.diagnostics", "Refused"),
    "Tool": ("assistant.program.geometry", "Tool"),
    "check": ("assistant.api.analysis", "check"),
    "compare": ("assistant.compiler", "compare"),
    "compile": ("assistant.compiler", "compile"),
    "connect": ("assistant.controllers", "connect"),
    "deploy": ("assistant.deploy", None),
    "from_joints": ("assistant.api.arrays", "from_joints"),
    "from_poses": ("assistant.api.arrays", "from_poses"),
    "languages": ("assistant.languages", None),
    "load": ("assistant.compiler", "load"),
    "on": ("assistant.base.cluster", "on"),
    "pose": ("assistant.languages.pose_conventions", None),
    "plan": ("assistant.cell.planning.planner", "plan"),
    "read_scene": ("assistant.cell.cell_file", "read_scene"),
    "robots": ("assistant.robots", None),
    "simulate": ("assistant.api.analysis", "simulate"),
    "translate": ("assistant.compiler", "translate"),
}
"""Public names, imported when first used so that the command line starts fast."""

__all__ = [
    "Frame",
    "Load",
    "Pose",
    "Proving",
    "Refused",
    "Tool",
    "__version__",
    "check",
    "compare",
    "compile",
    "connect",
    "deploy",
    "from_joints",
    "from_poses",
    "languages",
    "load",
    "on",
    "plan",
    "pose",
    "read_scene",
    "robots",
    "simulate",
    "translate",
]


__getattr__ = offered(__name__, _LAZY)
__dir__ = listed(__name__, _LAZY)

draw_by(
    {
        "Check": ("assistant.api.notebook", "check_html"),
        "Compiled": ("assistant.api.notebook", "compiled_html"),
        "Diagnostic": ("assistant.api.notebook", "finding_html"),
        "Path": ("assistant.api.notebook", "path_html"),
        "Program": ("assistant.api.notebook", "program_html"),
        "Recording": ("assistant.api.notebook", "recording_html"),
        "Robot": ("assistant.api.notebook", "robot_html"),
        "Robot.plot": ("assistant.api.notebook", "arm_figure"),
        "Samples": ("assistant.api.notebook", "samples_html"),
        "Simulated": ("assistant.api.notebook", "simulated_html"),
        "Translation": ("assistant.api.notebook", "translation_html"),
    }
)

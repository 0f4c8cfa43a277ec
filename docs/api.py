"""Prints `api.md`, what Python offers, from the signatures and docstrings themselves.

python -m docs.api > docs/api.md
"""

from __future__ import annotations

import dataclasses
import enum
import importlib
import inspect
import re
import sys
from collections.abc import Iterable, Iterator
from types import ModuleType
from typing import Any, Final

import assistant

HEAD: Final = """\
# Python, function by function

Printed from the docstrings: `help(assistant.compile)` says the same. [From Python](python.md) is
the tutorial. Lengths are mm, angles degrees, times seconds and quaternions w, x, y, z, unless it
is said otherwise.
"""
FUNCTIONS: Final = (
    "load", "compile", "translate", "compare", "check", "simulate", "from_poses", "from_joints",
    "plan", "read_scene", "on", "connect",
)  # fmt: skip
"""In the order of the page."""
CLASSES: Final = (
    "assistant.compiler.loader.Loaded",
    "assistant.compiler.compilation.Compiled",
    "assistant.compiler.translation.Translation",
    "assistant.compiler.comparison.Comparison",
    "assistant.compiler.comparison.Difference",
    "assistant.compiler.motion_proof.Proving",
    "assistant.api.analysis.Check",
    "assistant.api.analysis.Simulated",
    "assistant.base.diagnostics.Diagnostic",
    "assistant.base.diagnostics.Refused",
    "assistant.program.program.Program",
    "assistant.program.geometry.Pose",
    "assistant.program.geometry.Tool",
    "assistant.program.geometry.Load",
    "assistant.program.geometry.Frame",
    "assistant.robots.robot.Robot",
)
"""What they give."""
CONTROLLERS: Final = (
    "assistant.controllers.abb.exchange.PoseExchange",
    "assistant.controllers.abb.exchange.PlainExchange",
    "assistant.controllers.abb.exchange.Module",
    "assistant.controllers.abb.exchange.Answer",
    "assistant.controllers.abb.egm.guide",
    "assistant.controllers.mitsubishi.external_control.Mxt",
    "assistant.controllers.mitsubishi.external_control.Monitor",
    "assistant.controllers.mitsubishi.data_link.DataLink",
    "assistant.controllers.mitsubishi.data_link.Form",
    "assistant.controllers.mitsubishi.control_mode.ControlMode",
    "assistant.controllers.cyclic.Trajectory",
    "assistant.controllers.cyclic.Limits",
    "assistant.controllers.cyclic.ArmLimits",
    "assistant.controllers.cyclic.Settings",
    "assistant.controllers.cyclic.Report",
    "assistant.controllers.recording.Recording",
)
"""How arms are led and programs spoken with."""
BLOCKS: Final = (
    "assistant.blocks.diagrams",
    *(
        f"assistant.blocks.library.{name}"
        for name in (
            *("arms", "sources", "stopped_moves", "continuous_moves", "controller_io"),
            *("external_control", "sensors"),
        )
    ),
    "assistant.blocks.robot",
    "assistant.blocks.robot_around",
    "assistant.blocks.connections",
    "assistant.blocks.setpoint_connections",
)
"""Modules of blocks and of their connections to controllers."""
MODULES: Final = {
    "pose": ("of", "columns", "se3", "read", "write", "convert", "parse", "conventions"),
    "robots": ("get", "load", "names", "solve_program", "from_rtb"),
    "languages": ("get", "names", "of_file"),
    "deploy": ("plan", "deploy", "rollback", "verify", "resume", "deploy_to_all"),
}
"""Modules on top, with the functions that have a section each; the rest of `__all__` is rows."""
FURTHER: Final = {
    "Virtual controllers": (
        "assistant.virtual.irc5.VirtualIrc5",
        "assistant.virtual.irc5.Signal",
        "assistant.virtual.irc5.egm.VirtualEgm",
        "assistant.virtual.irc5.egm.Guidance",
        "assistant.virtual.irc5.rws_faults.Fault",
        "assistant.virtual.cr.VirtualCr",
        "assistant.virtual.cr.mxt.MxtArm",
        "assistant.virtual.cr.mxt_process.MxtProcess",
        "assistant.virtual.cr.real_time.MxtMonitor",
    ),
    "Leading arms": (
        "assistant.controllers",
        "assistant.controllers.cyclic.resampled",
        "assistant.controllers.trajectory_execution.LinkOptions",
        "assistant.controllers.trajectory_execution.mxt_installed",
        "assistant.controllers.trajectory_execution.on_network",
        "assistant.controllers.trajectory_execution.MXT_PROGRAM",
        "assistant.controllers.trajectory_execution.FIRST_PACKET_TIMEOUT",
        "assistant.controllers.mitsubishi.external_control.CYCLES",
        "assistant.controllers.mitsubishi.data_link.Joints",
        "assistant.controllers.mitsubishi.data_link.Rate",
        "assistant.controllers.recording.save_columns",
        "assistant.controllers.states.Jog",
    ),
    "Poses and figures": (
        "assistant.program.se3.columns_of",
        "assistant.program.se3.se3_of",
        "assistant.report.figures.Poses",
        "assistant.report.figures.passed_poses",
        "assistant.report.figures.point_plot",
    ),
    "Running programs": (
        "assistant.virtual.program_run.prepared",
        "assistant.compiler.simulated_run.read_script",
        "assistant.virtual.kernel.Kernel",
        "assistant.virtual.kernel.timed_arm.Timed",
        "assistant.virtual.kernel.timed_arm.track_of",
        "assistant.virtual.events.Said",
        "assistant.virtual.rapid.TaskProgram",
        "assistant.virtual.rapid.Given",
        "assistant.virtual.rapid.run_tasks",
        "assistant.virtual.rapid.controller.Controller",
        "assistant.virtual.rapid.controller.Options",
        "assistant.virtual.rapid.interpreter.start_task",
        "assistant.virtual.rapid.value_text.saved",
        "assistant.virtual.melfa.Controller",
        "assistant.virtual.melfa.Entry",
        "assistant.virtual.melfa.communication_lines.Wire",
        "assistant.virtual.melfa.world.STEP_TIME",
    ),
    "Programs as trees": (
        "assistant.program.pseudo",
        "assistant.program.expressions.Number",
        "assistant.program.statements.Wait",
        "assistant.languages.rapid.syntax",
        "assistant.resources.read_grammar",
        "assistant.compiler.check_files",
        "assistant.checks",
    ),
    "Projects": (
        "assistant.project.project_of",
        "assistant.project.targets_of",
        "assistant.project.build",
        "assistant.project.new_project.start_project",
    ),
    "The cell, cameras, calibration": (
        "assistant.cell.exploration.explorer.Explorer",
        "assistant.cell.exploration.explorer.Touch",
        "assistant.cell.exploration.explorer.wander",
        "assistant.cell.exploration.known_space.with_map",
        "assistant.vision.cameras.camera_file.read_cameras",
        "assistant.vision.cameras.camera.triangulate",
        "assistant.learning.measured_poses.read_measured",
        "assistant.learning.arm_calibration.calibrate",
    ),
    "More of the blocks": (
        "assistant.blocks.bdsim_adapter.run_bdsim",
        "assistant.blocks.bdsim_adapter.run_paced",
        "assistant.blocks.library.ports.joints_port",
        "assistant.blocks.code.kinematics",
    ),
}
"""What pages and samples import beside all that, a row each, by what it is for."""


def page() -> str:
    parts = [HEAD, "## Functions\n"]
    parts += [_function(f"assistant.{name}", getattr(assistant, name)) for name in FUNCTIONS]
    parts.append("## What they give\n")
    for path in CLASSES:
        module, _, name = path.rpartition(".")
        parts.append(_class(name, getattr(importlib.import_module(module), name)))
    for name, functions in MODULES.items():
        module: ModuleType = getattr(assistant, name)
        parts.append(f"## assistant.{name}\n\n{_first(module.__doc__)}\n")
        parts += [_function(f"assistant.{name}.{f}", getattr(module, f)) for f in functions]
        named = {*functions, *(path.rpartition(".")[2] for path in CLASSES)}
        rest = [one for one in offered(module) if one not in named]
        parts += [_row(f"assistant.{name}.{one}", getattr(module, one)) for one in rest]
        parts += [""] * bool(rest)
    parts.append("## Controllers\n\nEach is imported from its module.\n")
    for path in CONTROLLERS:
        module_name, _, name = path.rpartition(".")
        one = getattr(importlib.import_module(module_name), name)
        parts.append(_class(path, one) if isinstance(one, type) else _function(path, one))
    parts.append("## Blocks\n\n[Block diagrams](blocks.md) tells how they are put together.\n")
    for module_name in BLOCKS:
        module = importlib.import_module(module_name)
        parts.append(f"### {module_name}\n\n{_first(module.__doc__)}\n")
        parts += [f"{_row(name, one)}" for name, one in _public(module)]
        parts.append("")
    parts.append("## What pages and samples import\n\n`help(NAME)` says more of each.\n")
    for title, paths in FURTHER.items():
        parts.append(f"### {title}\n")
        parts += [_row(path, _imported(path)) for path in paths]
        parts.append("")
    return "\n".join(parts)


def offered(module: ModuleType) -> tuple[str, ...]:
    """The public names of a module on top: its `__all__`, else what it defines."""
    stated = getattr(module, "__all__", None)
    return tuple(stated or (name for name, _ in _public(module)))


def unlisted(page: str, paths: Iterable[str]) -> list[str]:
    """The dotted names that a page has neither a section nor a row for.

    Names of a module on top are listed with it, as several modules have a `get`.
    """
    named = set(re.findall(r"^(?:#{2,3} |- `)([\w.]+)", page, re.M))
    last = {name.rpartition(".")[2] for name in named}
    apart = {path.rpartition(".")[2] for path in CLASSES}

    def found(path: str) -> bool:
        module, _, name = path.rpartition(".")
        on_top = module.rpartition(".")[2] in MODULES and module.count(".") == 1
        return path in named if on_top and name not in apart else name in last

    return [path for path in paths if not found(path)]


def _imported(path: str) -> Any:
    module, _, name = path.rpartition(".")
    inside = importlib.import_module(module)
    return getattr(inside, name, None) or importlib.import_module(path)


def _public(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """Classes and functions that a module defines, with a docstring."""
    for name, value in vars(module).items():
        own = getattr(value, "__module__", "") == module.__name__
        if own and not name.startswith("_") and callable(value) and value.__doc__:
            yield name, value


def _row(name: str, one: Any) -> str:
    if isinstance(one, ModuleType):
        return f"- `{name}`: {_first(one.__doc__)}"
    if not callable(one):
        return f"- `{name}`: {one!r:.100}"
    made = one
    if isinstance(one, type):
        # Nobody makes members of an enumeration, nor a protocol.
        if isinstance(one, enum.EnumMeta) or getattr(one, "_is_protocol", False):
            return f"- `{name}`: {_first(one.__doc__)}"
        # Blocks of bdsim state the signature of the kind of block that they hold.
        made = one if "__signature__" in vars(one) else one.__init__
        made = made if made is not object.__init__ else lambda: None
    said = f": {_first(one.__doc__)}" if not str(one.__doc__).startswith(f"{one.__name__}(") else ""
    return f"- `{_signature(name, made, ' ').removesuffix(' -> None')}`{said}"


def _function(name: str, function: Any) -> str:
    prose = _listed(_prose(function), list(inspect.signature(function).parameters))
    return f"### {name}\n\n{_code(_signature(name, function))}\n\n{prose}\n"


def _class(name: str, kind: type) -> str:
    fields = dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()
    lines = [f"### {name}\n", _listed(_prose(kind), [one.name for one in fields]), ""]
    if fields:
        told = [f"{one.name}: {_type(one.type)}" for one in fields if not one.name.startswith("_")]
        lines += [_code("\n".join(told)), ""]
    for member, value in _members(kind):
        if isinstance(value, property):
            result = _type(inspect.signature(value.fget).return_annotation)  # type: ignore[arg-type]
            lines.append(f"- `{member}: {result}`: {_first(value.__doc__)}")
        else:
            lines.append(f"- `{_signature(member, value, ' ')}`: {_first(value.__doc__)}")
    return "\n".join(lines).rstrip() + "\n"


def _members(kind: type) -> Iterator[tuple[str, Any]]:
    """Properties, methods and static methods of a class of ours that say what they are for."""
    ours = [one for one in reversed(kind.__mro__) if one.__module__.startswith("assistant.")]
    for name, value in {n: v for one in ours for n, v in vars(one).items()}.items():
        value = value.__func__ if isinstance(value, staticmethod) else value
        told = isinstance(value, property) or inspect.isfunction(value)
        if told and not name.startswith("_") and value.__doc__:
            yield name, value


def _signature(name: str, function: Any, apart: str = "\n    ") -> str:
    """On one line if it fits, else a line for each argument."""
    signature = inspect.signature(function)
    words, keyword = [], False
    for one in signature.parameters.values():
        if one.name == "self":
            continue
        if one.kind is one.KEYWORD_ONLY and not keyword:
            keyword = True
            words.append("*")
        default = "" if one.default is one.empty else f" = {_default(one.default)}"
        typed = "" if one.annotation is one.empty else f": {_type(one.annotation)}"
        stars = {one.VAR_POSITIONAL: "*", one.VAR_KEYWORD: "**"}.get(one.kind, "")
        keyword |= one.kind is one.VAR_POSITIONAL
        words.append(f"{stars}{one.name}{typed}{default}")
    none = signature.return_annotation is signature.empty
    result = "" if none else f" -> {_type(signature.return_annotation)}"
    line = f"{name}({', '.join(words)}){result}"
    if len(line) <= 96 or apart == " ":
        return line
    return f"{name}({apart}" + f",{apart}".join(words) + f",\n){result}"


def _default(value: object) -> str:
    text = repr(value)
    return "…" if " at 0x" in text or len(text) > 40 else text


def _type(annotation: object) -> str:
    text = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", "")
    return str(text or annotation).replace("FilePath", "Path")


def _prose(thing: object) -> str:
    return inspect.cleandoc(getattr(thing, "__doc__", None) or "")


def _listed(prose: str, names: list[str]) -> str:
    """Prose in which what begins a sentence with `name: ` is a row of a list."""
    named = "|".join(map(re.escape, names)) or r"\Z"
    begin = re.compile(rf"(?:^|(?<=\. )|(?<=; ))((?:{named})(?:, (?:{named}))*): ", re.M)
    parts = []
    for paragraph in prose.split("\n\n"):
        line = re.sub(r"\s+", " ", paragraph)
        rows = begin.split(line)
        parts += [rows[0].strip()] if rows[0].strip() else []
        told = zip(rows[1::2], rows[2::2], strict=True)
        listed = "\n".join(f"- `{name}`: {said.strip()}" for name, said in told)
        parts += [re.sub(r"\.? (?=Raises )", ".\n\n", listed)] if listed else []
    return "\n\n".join(parts)


def _first(text: str | None) -> str:
    """The first paragraph, on one line."""
    paragraph = inspect.cleandoc(text or "").split("\n\n")[0]
    return re.sub(r"\s+", " ", paragraph)


def _code(text: str) -> str:
    return f"```text\n{text}\n```"


if __name__ == "__main__":
    sys.stdout.write(page())

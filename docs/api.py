"""Prints `api.md`, what Python offers, from the signatures and docstrings themselves.

python -m docs.api > docs/api.md
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
import sys
from collections.abc import Iterator
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
    "plan", "read_scene", "connect",
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
"""Modules on top, with the functions of each that the page tells."""


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
    return "\n".join(parts)


def _public(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """Classes and functions that a module defines, with a docstring."""
    for name, value in vars(module).items():
        own = getattr(value, "__module__", "") == module.__name__
        if own and not name.startswith("_") and callable(value) and value.__doc__:
            yield name, value


def _row(name: str, one: Any) -> str:
    made = one.__init__ if isinstance(one, type) else one
    kinds = {each.kind for each in inspect.signature(made).parameters.values()}
    # What only passes its arguments on has them in the page about blocks.
    if inspect.Parameter.VAR_POSITIONAL in kinds:
        return f"- `{name}`: {_first(one.__doc__)}"
    return f"- `{_signature(name, made, ' ').removesuffix(' -> None')}`: {_first(one.__doc__)}"


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
        words.append(f"{one.name}{typed}{default}")
    result = _type(signature.return_annotation)
    line = f"{name}({', '.join(words)}) -> {result}"
    if len(line) <= 96 or apart == " ":
        return line
    return f"{name}({apart}" + f",{apart}".join(words) + f",\n) -> {result}"


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

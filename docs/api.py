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
)
"""What they give."""
MODULES: Final = {
    "robots": ("get", "load", "names", "solve_program"),
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
    return "\n".join(parts)


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
    """Properties, methods and static methods of the class itself that say what they are for."""
    for name, value in vars(kind).items():
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

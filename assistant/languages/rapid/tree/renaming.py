"""Other names for data of modules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import MotionNames
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.runs.columns import Names
from assistant.program.rewriting import rewrite


def renamed(item: s.Item, names: Mapping[str, str]) -> s.Item:
    """An item with other names, by lower-case name, but for what a routine declares itself."""
    inner = {
        node.name.lower()
        for node in (nodes(item) if isinstance(item, s.Routine) else ())
        if isinstance(node, s.Data | s.ParameterNode)
    }

    def of(name: str) -> str:
        return name if name.lower() in inner else names.get(name.lower(), name)

    def said(part: Any) -> Any:
        match part:
            case s.NameRef(name) | s.Data(name=name):
                return replace(part, name=of(name))
            case s.ForLoop(variable=str(name)):
                return replace(part, variable=of(name))
            case MotionNames(speed, zone, tool, frame):
                return MotionNames(of(speed), of(zone), of(tool), of(frame))
            case Names():
                return Names.of([of(part.name(row)) for row in range(len(part))])
        return part

    return rewrite(item, said, ())

"""Tools and frames that a program sets to a pose: in RAPID the parts of a record.

`table = taught` becomes `table.uframe:=taught;`, and `table.oframe` no pose of its own where it is
declared with one; of a robtarget the parts of a pose are taken. A tool is `grip.tframe`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, ClassVar, Final

from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import is_position
from assistant.program.geometry import IDENTITY
from assistant.program.passes.legalisation import Changes, Legalisation, Rewording
from assistant.program.program import Procedure, Program

TOOL_FRAME: Final = "tframe"
USER_FRAME: Final = "uframe"
OBJECT_FRAME: Final = "oframe"
MOUNT_TYPES: Final = ("tooldata", "wobjdata")
RAPID_NAME: Final = "rapid"
POSE_PARTS: Final = ("trans", "rot")
"""Those of a position that are a pose."""


def with_set_mounts(job: Legalisation) -> Program:
    """The program with parts of tools and frames for those that it sets to a pose."""
    program = job.program
    if not (program.frames or program.tools):
        return program
    said = _Mounts(job)
    return replace(program, procedures=tuple(map(said.procedure, program.procedures)))


class _Mounts(Rewording):
    """own: names, in lower case, that the procedure at hand calls something else."""

    def __init__(self, job: Legalisation) -> None:
        super().__init__(job)
        program = job.program
        self.frames = {name.lower(): frame for name, frame in program.frames.items()}
        self.tools = {name.lower() for name in program.tools}
        self.shadows = {name.lower() for name in program.variables}
        self.own: set[str] = set()
        texts = (one.text for one in program.declarations if one.language == RAPID_NAME)
        self.kept = _mounts_in(verbatim.items, texts)
        self.records = self.kept

    def enter(self, procedure: Procedure) -> None:
        super().enter(procedure)
        self.own = self.shadows | {name.lower() for name in procedure.variables}
        self.own |= {parameter.name.lower() for parameter in procedure.parameters}
        texts = (one.text for one in procedure.body if isinstance(one, p.Opaque))
        self.records = self.kept | _mounts_in(verbatim.statements, texts)

    def assign(self, node: p.Assign) -> Iterator[p.Statement]:
        name = node.target.name.lower() if isinstance(node.target, e.Name) else ""
        if name in self.own or name not in {*self.frames, *self.tools} or self.is_whole(node.value):
            yield node
            return
        outer = USER_FRAME if name in self.frames else TOOL_FRAME
        yield replace(node, target=e.Member(node.target, outer), value=self.pose(node.value))
        if name in self.frames and self.frames[name].object != IDENTITY:
            yield replace(
                node, target=e.Member(node.target, OBJECT_FRAME), value=e.PoseValue(IDENTITY)
            )

    def is_whole(self, value: e.Expression) -> bool:
        """Whether a value is a tool or frame itself, or a record of one."""
        match value:
            case e.Name(name):
                low = name.lower()
                known = low in self.frames or low in self.tools or low in self.records
                return known and low not in self.own
            case e.Index(e.Name(name)):
                return name.lower() in self.records - self.own
            case e.Apply(name):
                routine = signature(name)
                told = routine is not None and routine.result in MOUNT_TYPES
                return told or name.lower() in self.records
        return isinstance(value, e.Aggregate | e.Verbatim)

    def pose(self, value: e.Expression) -> e.Expression:
        match value:
            case e.TargetValue(target):
                return e.PoseValue(target.pose)
            case e.Name() | e.Index() if is_position(value, self.known):
                return e.Aggregate(tuple(e.Member(value, part) for part in POSE_PARTS))
            case e.Apply("inverse", (inner,)):
                return e.inverse(self.pose(inner))
        return value

    changes: ClassVar[Changes] = {p.Assign: assign}


def _mounts_in(read: Callable[[str], Any], texts: Iterable[str]) -> frozenset[str]:
    """Lower-case names of the tools and work objects that kept texts declare.

    Functions that give one are among them.
    """
    nodes = (node for text in texts for node in verbatim.understood(read, text) or ())
    return frozenset(
        node.name.lower()
        for node in nodes
        if isinstance(node, s.Data | s.Routine) and node.type.lower() in MOUNT_TYPES
    )

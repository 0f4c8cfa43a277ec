"""A block diagram: blocks, the wires between their ports, and the order of its steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import TypeVar

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.blocks.diagrams import rules
from assistant.blocks.diagrams.block import Block

AnyBlock = TypeVar("B", bound=Block)
PortRef = tuple[Block, int]
"""A port of a block, by its number."""


@dataclass(frozen=True, slots=True)
class StepOrder:
    """order: blocks as they give their outputs. sources: of each block where its inputs come from.
    findings: what may be wrong and does not keep it from running.
    """

    order: tuple[Block, ...]
    sources: Mapping[Block, tuple[PortRef, ...]]
    findings: tuple[Diagnostic, ...]


class Diagram:
    """Blocks and wires.

    diagram = Diagram()
    way = diagram.add(Ramp("way", ...))
    arm = diagram.add(SimulatedArm("arm", robot))
    diagram.wire((way, "joints"), arm)
    """

    def __init__(self, name: str = "main") -> None:
        self.name = name
        self.blocks: list[Block] = []
        self._wires: dict[tuple[Block, int], PortRef] = {}

    def __repr__(self) -> str:
        return f"<Diagram {self.name}: {len(self.blocks)} blocks, {len(self._wires)} wires>"

    def _repr_png_(self) -> bytes | None:
        """Its blocks and wires, for notebooks; None without matplotlib."""
        from assistant.blocks.showing.pictures import diagram_png

        return diagram_png(self)

    def add(self, block: AnyBlock) -> AnyBlock:
        """Puts a block in and gives it back; raises Refused for a name that is taken."""
        if any(one.name == block.name for one in self.blocks):
            raise Refused(rules.SAME_BLOCK_NAME(name=block.name))
        self.blocks.append(block)
        return block

    def wire(
        self,
        start: Block | tuple[Block, str],
        end: Block | tuple[Block, str],
        *more: Block | tuple[Block, str],
    ) -> None:
        """From an output to one or more inputs; a port is named where a block has several.

        Raises Refused for ports that are not there, and for an input that has a wire.
        """
        source = self._port(start, "output")
        for one in (end, *more):
            block, number = self._port(one, "input")
            if (block, number) in self._wires:
                port = block.inputs[number].name
                raise Refused(rules.TWO_WIRES(port=port, block=block.name))
            self._wires[block, number] = source

    @property
    def wires(self) -> Sequence[tuple[PortRef, PortRef]]:
        """From where to where, in the order in which they were laid."""
        return [(start, end) for end, start in self._wires.items()]

    def plan(self) -> StepOrder:
        """The order of its steps; raises Refused for inputs without a wire and for loops."""
        missing = [
            rules.NO_WIRE(port=port.name, block=block.name)
            for block in self.blocks
            for number, port in enumerate(block.inputs)
            if (block, number) not in self._wires
        ]
        unlike = [found for wire in self.wires if (found := _port_mismatch(*wire)) is not None]
        wrong = [*missing, *(one for one in unlike if one.severity == "error")]
        if wrong:
            raise Refused(*wrong)
        sources = {
            block: tuple(self._wires[block, number] for number in range(len(block.inputs)))
            for block in self.blocks
        }
        waits = {
            block: [start for start, _ in sources[block]] if block.direct else []
            for block in self.blocks
        }
        try:
            order = tuple(TopologicalSorter(waits).static_order())
        except CycleError as error:
            names = " → ".join(f"`{block.name}`" for block in error.args[1])
            raise Refused(rules.ALGEBRAIC_LOOP(names=names)) from None
        return StepOrder(order, sources, tuple(unlike))

    def _port(self, given: Block | tuple[Block, str], kind: str) -> PortRef:
        block, name = given if isinstance(given, tuple) else (given, None)
        if block not in self.blocks:
            raise Refused(rules.BLOCK_OF_NO_DIAGRAM(name=block.name))
        ports = block.outputs if kind == "output" else block.inputs
        found = [i for i, port in enumerate(ports) if name in (None, port.name)]
        if len(found) != 1:
            known = ", ".join(f"`{port.name}`" for port in ports) or "none"
            said = name or "that is the only one"
            raise Refused(rules.NO_PORT(block=block.name, kind=kind, name=said, known=known))
        return block, found[0]


def _port_mismatch(start: PortRef, end: PortRef) -> Diagnostic | None:
    """What does not fit between two ports."""
    one, other = start[0].outputs[start[1]], end[0].inputs[end[1]]
    given, wanted = f"{start[0].name}.{one.name}", f"{end[0].name}.{other.name}"
    if not other.takes(one.size):
        return rules.OTHER_SIGNAL_SIZE(start=given, end=wanted, given=one.size, wanted=other.wanted)
    if one.unit != other.unit and one.unit and other.unit:
        return rules.OTHER_SIGNAL_UNIT(start=given, end=wanted, given=one.unit, wanted=other.unit)
    return None

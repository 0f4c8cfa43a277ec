"""Blocks of one's own in diagrams of bdsim, without a class of bdsim for each of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bdsim.blockdiagram import BlockDiagram
    from bdsim.components import Clock

    from assistant.blocks.diagrams.block import Block


def add(diagram: BlockDiagram, block: Block, clock: Clock | None = None) -> Any:
    """Puts a block of ours into a diagram of bdsim; gives the block of bdsim, to be connected.

    clock: at whose ticks it steps; None for a block that is a function of the signals of the
    moment. Raises ValueError for a block that remembers something (`direct` is False) without one.
    """
    from bdsim.block import FunctionBlock, SampledBlock

    from assistant.blocks import robot

    if clock is None and not block.direct:
        raise ValueError(f"block `{block.name}` steps with a clock, and none is given")
    name = type(block).__name__
    if clock is None:
        ports = {"nin": len(block.inputs)}
        made = type(name, (robot._Direct, FunctionBlock), ports)(block)
    else:
        made = type(name, (robot._Stepped, SampledBlock), {})(block, clock)
    made.type = name.lower()
    diagram.add_block(made)
    return made

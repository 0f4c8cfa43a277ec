"""Block diagrams that are stepped: blocks, their wires, clocks, what a run gives."""

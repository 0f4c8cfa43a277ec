"""Bodies of drawings (DXF): meshes, extruded outlines, and blocks of these with their inserts."""

from __future__ import annotations

from assistant.cell.reading.drawings.bodies import Drawn, read_drawing

__all__ = ["Drawn", "read_drawing"]

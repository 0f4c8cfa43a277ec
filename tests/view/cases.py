"""A program in a small cell, and the data of its page."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats

PROGRAM: Final = """program cell for irb1200-7-0.7

target a [400, -100, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]

procedure main
  move joint a speed 500 mm/s blend fine
  for i from 1 to 3
    call forth
  end
end

procedure forth
  move linear b speed 100 mm/s blend fine
  wait 0.5 s
  move linear a speed 200 mm/s blend fine
end
"""
CELL: Final = """
[robots.arm]
robot = "irb1200-7-0.7"
position = [50, 0, 20]

[bodies.post]
cylinder = [20, 300]
position = [450, 0, 420]
colour = "#2050ff"

[bodies.post.locations.top]
position = [0, 0, 150]
"""


def written(folder: Path) -> tuple[Path, Path]:
    """The program and the cell file."""
    program, cell = folder / "seam.pseudo", folder / "cell.toml"
    program.write_text(PROGRAM, encoding="utf-8")
    cell.write_text(CELL, encoding="utf-8")
    return program, cell


def data_of(page: str) -> dict[str, Any]:
    """What the script of a page is given."""
    found = re.findall(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    (text,) = found
    data: dict[str, Any] = json.loads(text)
    return data


def numbers(column: str) -> Floats:
    return np.frombuffer(base64.b64decode(column), "<f4").astype(np.float64)

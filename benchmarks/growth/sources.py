"""Sources that grow: tables, taught targets, process files, drawings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from benchmarks.growth.construct import Construct, Text

_HEAD: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,speed_mm_s,blend_mm,tool,motion\n"
_TOOL: Final = "[tools.t]\ntip = [0, 0, 60]\nmass = 0.5\ncentre = [0, 0, 30]\n"


def _tool(_: int) -> str:
    return _TOOL


def _table(n: int) -> str:
    return _HEAD + "".join(f"{250 + k / 9:.3f},0,300,0,1,0,0,150,1,t,linear\n" for k in range(n))


def _bad_table(n: int) -> str:
    return _HEAD + "".join(f"{k},a,300,0,1,0,0,150,1,t,linear\n" for k in range(n))


def _table_of_tools(n: int) -> str:
    return _HEAD + "".join(f"{k},0,300,0,1,0,0,150,1,t{k},linear\n" for k in range(n))


def _wide_table(n: int) -> str:
    head = _HEAD.strip() + "".join(f",a{k}" for k in range(n))
    return f"{head}\n1,0,300,0,1,0,0,150,1,t,linear" + ",1" * n + "\n"


def _tools(n: int) -> str:
    return "".join(_TOOL.replace("tools.t", f"tools.t{k}") for k in range(n))


def _signals(n: int) -> str:
    rows = (
        f'[signals.s{k}]\nkind = "digital"\ndirection = "output"\nnumber = {k}\n' for k in range(n)
    )
    return _TOOL + "".join(rows)


def _deep(n: int) -> str:
    return _TOOL + "a = " + "[" * n + "]" * n + "\n"


def _taught(name: str) -> Text:
    def text(n: int) -> str:
        head = '[motion]\nspeed = 100\nblend = "fine"\ntool = "t"\n' + _TOOL
        rows = (
            f'[[targets]]\nname = "{name}{k if name else ""}"\nposition = [{k}, 0, 300]\n'
            "euler_zyx = [0, 0, 180]\n"
            for k in range(n)
        )
        return head + "".join(rows)

    return text


def _one_name(n: int) -> str:
    return _taught("")(n).replace('name = ""', 'name = "a"')


def _drawing(*entities: str, blocks: str = "", header: str = "") -> str:
    parts = [f"0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n{header}0\nENDSEC\n"]
    if blocks:
        parts.append(f"0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n")
    parts.append("0\nSECTION\n2\nENTITIES\n" + "".join(entities) + "0\nENDSEC\n0\nEOF\n")
    return "".join(parts)


def _line(k: int, layer: str) -> str:
    return f"0\nLINE\n8\n{layer}\n10\n{k}\n20\n0\n11\n{k}\n21\n5\n"


def _lines(n: int) -> str:
    return _drawing(*(_line(k, "CUT") for k in range(n)))


def _joined_lines(n: int) -> str:
    def line(k: int) -> str:
        return f"0\nLINE\n8\nCUT\n10\n{k}\n20\n{k % 2}\n11\n{k + 1}\n21\n{(k + 1) % 2}\n"

    return _drawing(*map(line, range(n)))


def _same_lines(n: int) -> str:
    return _drawing(*(_line(0, "CUT") for _ in range(n)))


def _circles(n: int) -> str:
    return _drawing(*(f"0\nCIRCLE\n8\nCUT\n10\n{3 * k}\n20\n0\n40\n1\n" for k in range(n)))


def _corners(n: int) -> str:
    rows = (f"0\nVERTEX\n8\nCUT\n10\n{k}\n20\n{k % 2}\n" for k in range(n + 1))
    return _drawing("0\nPOLYLINE\n8\nCUT\n66\n1\n70\n0\n", *rows, "0\nSEQEND\n8\nCUT\n")


def curve(n: int) -> str:
    """Chords of a closed curve of 8 m across, as dense as there are many."""
    turn = [math.tau * k / n for k in range(n + 1)]
    size = [3800.0 + 500.0 * math.sin(9.0 * one) for one in turn]
    rows = (
        f"0\nVERTEX\n8\nCUT\n10\n{r * math.cos(t):.6f}\n20\n{r * math.sin(t):.6f}\n"
        for r, t in zip(size, turn, strict=True)
    )
    return _drawing("0\nPOLYLINE\n8\nCUT\n66\n1\n70\n0\n", *rows, "0\nSEQEND\n8\nCUT\n")


def _layers(n: int) -> str:
    return _drawing(*(_line(k, f"L{k}") for k in range(n)))


def _layers_of_process(n: int) -> str:
    rows = (
        f'[layers.L{k}]\nprocess = "cutting"\nspeed = 20\nblend = 0.5\n'
        "approach = 40\nretract = 40\ntravel = 150\n"
        for k in range(n)
    )
    return _PROCESS + "".join(rows)


def _inserts(n: int) -> str:
    block = "0\nBLOCK\n2\nB\n8\n0\n10\n0\n20\n0\n" + _line(0, "CUT") + "0\nENDBLK\n"
    return _drawing(*(f"0\nINSERT\n2\nB\n8\nCUT\n10\n{k}\n20\n0\n" for k in range(n)), blocks=block)


def _blocks_in_each_other(n: int) -> str:
    rows = []
    for k in range(n):
        inner = f"0\nINSERT\n2\nB{k + 1}\n8\nCUT\n10\n1\n20\n0\n" if k + 1 < n else _line(0, "CUT")
        rows.append(f"0\nBLOCK\n2\nB{k}\n8\n0\n10\n0\n20\n0\n{inner}0\nENDBLK\n")
    return _drawing("0\nINSERT\n2\nB0\n8\nCUT\n10\n0\n20\n0\n", blocks="".join(rows))


def _points(n: int) -> str:
    return _drawing(*(f"0\nPOINT\n8\nP\n10\n{k}\n20\n0\n30\n5\n" for k in range(n)))


_PROCESS: Final = (
    'tolerance = 0.05\n[motion]\nkind = "linear"\nspeed = 100\nblend = "fine"\ntool = "t"\n' + _TOOL
)
_CUT: Final = (
    '[layers.CUT]\nprocess = "cutting"\nspeed = 20\nblend = 0.5\napproach = 40\nretract = 40\n'
    "travel = 150\n"
)


def _cut(_: int) -> str:
    return _PROCESS + _CUT


def _beside(_: int) -> str:
    return _PROCESS + _CUT + 'offset = 0.2\nside = "left"\n'


def far_beside(_: int) -> str:
    """A process file whose tool stays 2 mm off, within 0.01 mm: no chord of a curve is left out."""
    return _beside(1).replace("0.2", "2.0").replace("0.05", "0.01")


_ROWS: Final[tuple[tuple[str, str, Text, Text | None], ...]] = (
    ("CSV: rows", ".csv", _table, _tool),
    ("CSV: wrong rows", ".csv", _bad_table, _tool),
    ("CSV: tools", ".csv", _table_of_tools, _tools),
    ("CSV: unknown tools", ".csv", _table_of_tools, _tool),
    ("CSV: columns", ".csv", _wide_table, _tool),
    ("process file: signals", ".csv", lambda _: _table(1), _signals),
    ("process file: brackets", ".csv", lambda _: _table(1), _deep),
    ("taught: targets", ".toml", _taught("a"), None),
    ("taught: targets of one name", ".toml", _one_name, None),
    ("DXF: lines", ".dxf", _lines, _cut),
    ("DXF: lines that are joined", ".dxf", _joined_lines, _cut),
    ("DXF: the same line", ".dxf", _same_lines, _cut),
    ("DXF: circles", ".dxf", _circles, _cut),
    ("DXF: corners", ".dxf", _corners, _cut),
    ("DXF: corners with an offset", ".dxf", _corners, _beside),
    ("DXF: chords of a curve with an offset", ".dxf", curve, far_beside),
    ("DXF: layers", ".dxf", _layers, _cut),
    ("DXF: layers of the process", ".dxf", _layers, _layers_of_process),
    ("DXF: inserts", ".dxf", _inserts, _cut),
    ("DXF: blocks in each other", ".dxf", _blocks_in_each_other, _cut),
    ("DXF: points", ".dxf", _points, _cut),
)


def sources() -> Iterator[Construct]:
    """All of them."""
    for name, suffix, text, process in _ROWS:
        yield Construct(name, suffix, text, process=process)

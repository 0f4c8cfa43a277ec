"""Cures of what cameras see: pictures, known objects, places that are shown, frames."""

from __future__ import annotations

import datetime
import io
import struct
import zlib
from typing import Any, Final

import ezdxf
import numpy as np

from tests.findings.cures.case import Case, dxf, sample


def png(grey: np.ndarray) -> bytes:
    """Of (h, w) grey levels, by the standard of these files (ISO 15948)."""
    height, width = grey.shape
    rows = np.insert(grey.astype(np.uint8), 0, 0, axis=1)
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = ((b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes())), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )


def _archive(**columns: object) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **columns)  # type: ignore[arg-type]
    return buffer.getvalue()


# ------------------------------------------------------------------------------------- cameras

LEFT: Final = "[cameras.left]\nsize = [64, 48]\nfocal = [80, 80]\ncentre = [31.5, 23.5]\n"
DOWN: Final = "position = [0, 0, 500]\nquaternion = [0, 1, 0, 0]\n"
CARRIED: Final = 'parent = "arm.flange"\n'
AT: Final = "x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,300,1,0,0,0\n"
CELL: Final = '[robots.arm]\nrobot = "rv-2aj"\n'
SEEN: Final = {"c.toml": LEFT, "at.csv": AT, "cell.toml": CELL}
HUNG: Final = {**SEEN, "c.toml": LEFT + CARRIED}
DRAW: Final = "camera draw c.toml -o p"
VIEW: Final = "camera view c.toml left -o v.png"
CAMERAS: Final = (
    Case("CL501", VIEW, SEEN, change={"c.toml": LEFT + 'source = "cell.toml"\n'}, slow=True),
    Case("CL501", VIEW, SEEN, then=(f"{VIEW} --source cell.toml",)),
    Case("CL503", DRAW, SEEN, then=(f"{DRAW} --at at.csv",)),
    Case("CL503", DRAW, SEEN, then=(f"{DRAW} --cell cell.toml",), slow=True),
    Case("VS027", f"{DRAW} --at at.csv", HUNG, (f"{DRAW} --at at.csv --cell cell.toml",)),
    Case("VS027", f"{DRAW} --at at.csv", HUNG, (f"{DRAW} --at at.csv --poses at.csv",)),
)

# ------------------------------------------------------------------------------- known objects

SQUARE: Final = ((0, 0), (40, 0), (40, 30), (0, 20))


def closed(space: Any) -> None:
    space.add_lwpolyline(SQUARE, close=True, dxfattribs={"layer": "PART"})
    space.add_line((2, 2), (9, 9), dxfattribs={"layer": "GLUE"})


def bare(space: Any) -> None:
    """The bracket of the samples without its places and lines."""
    drawn = ezdxf.read(io.StringIO(sample("objects/bracket.dxf").decode()))  # type: ignore[attr-defined]
    (part,) = drawn.modelspace().query('LWPOLYLINE[layer=="PART"]')
    space.add_lwpolyline(part.get_points(), close=True, dxfattribs={"layer": "PART"})


def two_layers(space: Any) -> None:
    closed(space)
    space.add_lwpolyline(((5, 5), (9, 5), (9, 8)), close=True, dxfattribs={"layer": "HOLE"})


PART: Final = {"a.dxf": dxf(closed)}
ADD: Final = "objects add lib part a.dxf"
LIST: Final = "objects list lib"
EMPTY: Final = {**PART, "lib/library.toml": "version = 1\n"}
OTHER: Final = {"lib/part.npz": _archive(kind=np.array("something else"))}
NOISY: Final = png(np.random.default_rng(1).integers(0, 256, (24, 24)).repeat(8, 0).repeat(8, 1))
FACE: Final = {"face.png": NOISY}
SHOWN: Final = "objects add lib card face.png"
WIDE: Final = LEFT.replace("[64, 48]", "[192, 192]").replace("[31.5, 23.5]", "[95.5, 95.5]") + DOWN
PLAIN: Final = png(np.full((48, 64), 90))
LOOK: Final = "see left.png --cameras c.toml --objects lib"
TO_SEE: Final = {**PART, "left.png": PLAIN, "cell.toml": CELL}
TWO: Final = CELL + CELL.replace("arm", "other") + "position = [0, 1500, 0]\n"
BRACKET: Final = {
    name: sample(f"objects/{name}") for name in ("bracket.dxf", "cameras.toml", "table.toml")
}
KNOWN: Final = "objects add lib bracket bracket.dxf --height 3"
FOUND: Final = ("camera draw cameras.toml --cell table.toml -o shown", KNOWN)
SEE: Final = "see shown/above/0000.png --cameras cameras.toml --objects lib --plane 200 --to t.toml"
OBJECTS: Final = (
    Case("VS301", LIST, PART, (ADD, LIST)),
    Case("VS303", LIST, PART, (f"{ADD} --again", LIST), before=(ADD,), between=OTHER),
    Case("VS304", LIST, EMPTY, (ADD, LIST)),
    Case("VS305", ADD, PART, (f"{ADD} --again",), before=(ADD,)),
    Case("VS310", f"{ADD} --contour GLUE", PART, (f"{ADD} --contour PART",)),
    Case("VS311", ADD, {"a.dxf": dxf(two_layers)}, (f"{ADD} --contour PART",)),
    Case("VS323", SHOWN, FACE, (f"{SHOWN} --width 100",)),
    Case(
        "VS323",
        SHOWN,
        FACE | {"c.toml": WIDE},
        (f"{SHOWN} --cameras c.toml --width 100",),
        slow=True,
    ),
    Case(
        "VS336",
        f"{LOOK} --plane 600",
        TO_SEE | {"c.toml": LEFT + DOWN},
        (f"{LOOK} --plane 300",),
        before=(ADD,),
        others=("VS340",),
    ),
    Case(
        "VS337",
        LOOK,
        TO_SEE | {"c.toml": LEFT + CARRIED},
        (f"{LOOK} --cell cell.toml --joints 0,0,90,90,0",),
        before=(ADD,),
        others=("VS340",),
    ),
    Case(
        "VS341",
        f"{LOOK} --expect cover",
        TO_SEE | {"c.toml": LEFT + DOWN},
        (LOOK,),
        before=(ADD,),
        others=("VS340",),
    ),
    Case(
        "CL553",
        f"{LOOK} --cell cell.toml",
        TO_SEE | {"c.toml": LEFT + DOWN, "cell.toml": TWO},
        (f"{LOOK} --cell cell.toml --robot arm",),
        before=(ADD,),
        others=("VS340",),
    ),
    Case(
        "CL554",
        LOOK.replace("left.png ", ""),
        TO_SEE | {"c.toml": LEFT + DOWN},
        change={"c.toml": LEFT + DOWN + 'source = "left.png"\n'},
        before=(ADD,),
        others=("VS340",),
    ),
    Case("VS348", SEE.replace("200", "188"), BRACKET, (SEE,), before=FOUND, slow=True),
    Case(
        "VS350",
        SEE,
        BRACKET | {"bare.dxf": dxf(bare)},
        (f"{KNOWN} --line GLUE --again", SEE),
        before=(FOUND[0], KNOWN.replace("bracket.dxf", "bare.dxf")),
        slow=True,
    ),
)

# ---------------------------------------------------------------------- places that are shown

EYES: Final = {"c.toml": LEFT + LEFT.replace("left", "right") + "position = [100, 0, 0]\n"}
FED: Final = EYES["c.toml"].replace("size", 'source = "none"\nsize')
POINT: Final = "teach --point c.toml"
STROKE: Final = f"{POINT} --stroke --into"
DRIVEN: Final = '[controllers.cell1]\naddress = "virtual:cr"\n'
GO: Final = "teach cell1 a --point c.toml --go --yes --line 127.0.0.1:1 --line 127.0.0.1:2"

SHOWING: Final = (
    Case(
        "CL514",
        f"{STROKE} w.csv",
        EYES | {"w.csv": "x,y\n"},
        (f"{STROKE} v.csv",),
        others=("VS120",),
    ),
    Case(
        "CL514",
        f"{STROKE} w.csv",
        EYES | {"w.csv": "x,y\n"},
        (f"{STROKE} w.csv --replace",),
        others=("VS120",),
    ),
    Case("CL516", "teach cell1 --go", EYES, (f"teach --go {POINT[6:]}",), others=("CL510",)),
    Case("CL518", "teach", EYES, (POINT,), others=("VS120",)),
    Case("CL519", f"{POINT} --servo s.toml", EYES, (f"{POINT} --go",), others=("CL510",)),
    Case("VS120", POINT, EYES, change={"c.toml": FED}, others=("VS020",)),
)

# ---------------------------------------------------------------------------- frames that are seen

SEAM: Final = """program seam

frame part user [300, 0, 200] seen bracket

target on [0, 0, 10] [0, 0, 1, 0]

procedure main
  move linear on speed 50 mm/s blend fine frame part
end
"""
HOUR_AGO: Final = datetime.datetime.now(datetime.UTC) - datetime.timedelta(hours=1)
LAID: Final = f"""[found.bracket]
position = [320, 15, 210]
quaternion = [1, 0, 0, 0]
sigma_mm = 0.2
sigma_deg = 0.1
confidence = 0.97
seen = {HOUR_AGO.isoformat(timespec="seconds")}
"""
OLD: Final = "[seen]\noldest = 1_000_000\n"
SIGHT: Final = {"s.pseudo": SEAM, "p.toml": OLD, "f.toml": LAID, "cell.toml": CELL}
CHECK: Final = "check s.pseudo --robot irb1200-7-0.7 -p p.toml"
WRITE: Final = "compile s.pseudo --robot irb1200-7-0.7 -l rapid -p p.toml"
ASK: Final = f"{WRITE} --ask-at pc:10010"
IN_WORLD: Final = LAID + 'frame = "world"\n'
ONE: Final = '[robots.arm]\nrobot = "irb1200-7-0.7"\n'
STANDS: Final = ONE + ONE.replace("arm", "other") + "position = [0, 3000, 0]\n"
THERE: Final = "check s.pseudo -p p.toml --seen f.toml"
NOWHERE: Final = SEAM.replace("user [300, 0, 200] ", "")
FRAMES: Final = (
    Case("CO350", CHECK, SIGHT, (f"{CHECK} --seen f.toml",)),
    Case("CO350", WRITE, SIGHT, (ASK,)),
    Case("CO350", WRITE, SIGHT, change={"p.toml": '[seen]\nask = "pc:10010"\n'}),
    Case(
        "CO352",
        f"{CHECK} --seen f.toml",
        SIGHT | {"f.toml": IN_WORLD, "cell.toml": STANDS},
        (f"{THERE} --cell cell.toml --robot arm",),
    ),
    Case("CO352", f"{CHECK} --seen f.toml", SIGHT | {"f.toml": IN_WORLD}, change={"f.toml": LAID}),
    Case("CO354", ASK, SIGHT | {"s.pseudo": NOWHERE}, (f"{ASK} --seen f.toml",)),
    Case("CO354", ASK, SIGHT | {"s.pseudo": NOWHERE}, change={"s.pseudo": SEAM}),
    Case(
        "CO355",
        ASK,
        SIGHT
        | {
            "s.pseudo": SEAM.replace("program seam", "program seam without entry").replace(
                "main", "weld"
            )
        },
        (f"{WRITE} --seen f.toml",),
    ),
    Case(
        "SR012",
        f"{CHECK} --seen f.toml",
        SIGHT | {"p.toml": "[seen]\nconfidence = 0.9\n"},
        change={"p.toml": OLD},
    ),
    *(
        Case(
            code,
            f"{CHECK} --seen f.toml",
            SIGHT | {"f.toml": LAID.replace(good, bad)},
            change={"p.toml": OLD + allowed},
        )
        for code, good, bad, allowed in (
            ("SR014", "sigma_mm = 0.2", "sigma_mm = 1.5", "sigma_mm = 2\n"),
            ("SR014", "sigma_deg = 0.1", "sigma_deg = 1.5", "sigma_deg = 2\n"),
            ("SR015", "0.97", "0.5", "confidence = 0.4\n"),
        )
    ),
    Case(
        "SR010",
        f"{CHECK} --seen f.toml",
        SIGHT | BRACKET | {"f.toml": "[found]\n"},
        (SEE.replace("--to t.toml", "--found g.toml"), f"{CHECK} --seen g.toml"),
        before=FOUND,
        slow=True,
    ),
)
CASES: Final = (*CAMERAS, *OBJECTS, *SHOWING, *FRAMES)

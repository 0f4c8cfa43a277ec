"""The page: its parts, the library that draws and the data, in one file that needs no other."""

from __future__ import annotations

import html
import json
from importlib.resources import files
from typing import Final

from assistant.view.motion import Record
from assistant.view.record import Shown, record

LIBRARY: Final = "three/three.js"
"""three.js, see `three/README.md` for its version, its licence and how it is made."""
SCRIPTS: Final = ("data", "scene", "lines", "camera", "time", "lists", "source", "live", "start")
"""What draws, in its order; together they are one function of the page."""


def page(shown: Shown) -> str:
    """One HTML file without anything from outside. Raises Refused as `record` does."""
    return filled(record(shown))


def filled(data: Record) -> str:
    """The page of the data that `record` gives."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    parts = {
        "title": html.escape(str(data["title"])),
        "style": _own("viewer.css"),
        # `<` ends a script wherever it stands in front of `/script`, also in a string.
        "data": text.replace("<", "\\u003c").replace("\u2028", "\\u2028"),
        "library": _own(LIBRARY).replace("</script", "<\\/script"),
        "viewer": "".join(_own(f"scripts/{name}.js") for name in SCRIPTS),
        # A page that follows a controller asks where it comes from for that; any other asks nobody.
        "asked": "'none'" if data.get("live") is None else "'self'",
    }
    out = _own("viewer.html")
    head, *rest = out.split("{{")
    found = [head]
    for piece in rest:
        name, tail = piece.split("}}", 1)
        found += [parts[name.strip()], tail]
    return "".join(found)


def _own(name: str) -> str:
    return files("assistant").joinpath("view", *name.split("/")).read_text(encoding="utf-8")

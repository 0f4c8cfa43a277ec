"""The page: its parts, the library that draws and the data, in one file that needs no other."""

from __future__ import annotations

import html
import json
from importlib.resources import files
from typing import Final

from assistant.view.motion import Record
from assistant.view.record import page_record
from assistant.view.shown import Shown

DRAWING_LIBRARY: Final = "three/three.js"
"""three.js, see `three/README.md` for its version, its licence and how it is made."""
SCRIPTS: Final = (
    *("data", "scene", "lines", "plan", "camera", "time", "lists", "table", "source", "live"),
    "picking",
    "start",
)
"""What draws, in its order; together they are one function of the page."""


def page(*shown: Shown) -> str:
    """One HTML file without anything from outside, for one program or for several of which one is
    chosen on it. Raises Refused as `record` does.
    """
    return filled_page(*map(page_record, shown))


def filled_page(*programs: Record, nonce: str = "") -> str:
    """The page of the data that `record` gives for each of them.

    nonce: of whoever serves it: nothing is run then that does not bear it. What a page that is
    shown inside of another one is given beside the data, see `scripts/picking.js`.
    """
    first, *others = programs
    chosen = [str(one["title"]) for one in programs] if others else []
    title = str(first["title"]) if not others else f"{first['title']} and {len(others)} more"
    more = (
        f'<script id="data-{number}" type="application/json">{_script_json(one)}</script>\n'
        for number, one in enumerate(others, start=1)
    )
    parts = {
        "title": html.escape(title),
        "style": _own_file("viewer.css"),
        "data": _script_json(first | {"chosen": chosen} if others else first),
        "more": "".join(more),
        "library": _own_file(DRAWING_LIBRARY).replace("</script", "<\\/script"),
        "viewer": "".join(_own_file(f"scripts/{name}.js") for name in SCRIPTS),
        "nonce": f' nonce="{html.escape(nonce)}"' if nonce else "",
        "own": f"'nonce-{html.escape(nonce)}'" if nonce else "'unsafe-inline'",
        # A page that follows a controller asks where it comes from for that; any other asks nobody.
        "asked": "'none'" if first.get("live") is None else "'self'",
    }
    out = _own_file("viewer.html")
    head, *rest = out.split("{{")
    found = [head]
    for piece in rest:
        name, tail = piece.split("}}", 1)
        found += [parts[name.strip()], tail]
    return "".join(found)


def _script_json(data: Record) -> str:
    """Data as JSON that ends no script: `<` does wherever it stands in front of `/script`, also in
    a string.
    """
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028")


def _own_file(name: str) -> str:
    return files("assistant").joinpath("view", *name.split("/")).read_text(encoding="utf-8")

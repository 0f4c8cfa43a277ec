"""The page of the studio, its styles and scripts; nothing of it comes from outside."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Final

from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from assistant.studio.answering import NOT_THERE

KINDS: Final = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}
FOLDERS: Final = ("", "scripts", "codemirror")
"""Folders of files that the page loads."""
FIRST: Final = "en"
"""The language whose words all others are measured by."""


async def page(request: Request) -> Response:
    nonce = request.scope["state"]["nonce"]
    text = _text().replace("{{ nonce }}", nonce)
    return Response(text, media_type="text/html; charset=utf-8")


async def part(request: Request) -> Response:
    """One of our own files, by a name that is listed; nothing else of the disk is asked for."""
    found = _parts().get(request.path_params["name"])
    if found is None:
        return PlainTextResponse("not here", NOT_THERE)
    data, kind = found
    return Response(data, media_type=kind)


def words() -> dict[str, dict[str, str]]:
    """Texts of the page by language, each as its table says; a word that it lacks is English."""
    tables = {
        file.name.removesuffix(".toml"): tomllib.loads(file.read_text(encoding="utf-8"))
        for file in _folder("words").iterdir()
        if file.name.endswith(".toml")
    }
    first = tables[FIRST]
    return {name: first | table for name, table in sorted(tables.items())}


@cache
def _text() -> str:
    told = json.dumps(words(), ensure_ascii=False).replace("<", "\\u003c")
    return _folder("studio.html").read_text(encoding="utf-8").replace("{{ words }}", told)


@cache
def _parts() -> dict[str, tuple[bytes, str]]:
    found = {}
    for folder in FOLDERS:
        for file in _folder(folder).iterdir():
            suffix = file.name[file.name.rfind(".") :]
            if suffix in KINDS and file.name != "entry.js":
                name = f"{folder}/{file.name}".lstrip("/")
                found[name] = file.read_bytes(), KINDS[suffix]
    return found


def _folder(name: str) -> Traversable:
    here = files("assistant").joinpath("studio")
    return here.joinpath(name) if name else here


ROUTES: Final = (Route("/", page), Route("/parts/{name:path}", part))

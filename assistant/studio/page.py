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

from assistant.studio.answering import NOT_FOUND

MEDIA_TYPES: Final = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}
PART_FOLDERS: Final = ("", "scripts", "codemirror")
"""Folders of files that the page loads."""
FIRST_LANGUAGE: Final = "en"
"""The language whose words all others are measured by."""


async def page(request: Request) -> Response:
    nonce = request.scope["state"]["nonce"]
    text = _page_text().replace("{{ nonce }}", nonce)
    return Response(text, media_type="text/html; charset=utf-8")


async def page_part(request: Request) -> Response:
    """One of our own files, by a name that is listed; nothing else of the disk is asked for."""
    found = _part_bytes().get(request.path_params["name"])
    if found is None:
        return PlainTextResponse("not here", NOT_FOUND)
    data, kind = found
    return Response(data, media_type=kind)


def words() -> dict[str, dict[str, str]]:
    """Texts of the page by language, each as its table says; a word that it lacks is English."""
    tables = {
        file.name.removesuffix(".toml"): tomllib.loads(file.read_text(encoding="utf-8"))
        for file in _part_folder("words").iterdir()
        if file.name.endswith(".toml")
    }
    first = tables[FIRST_LANGUAGE]
    return {name: first | table for name, table in sorted(tables.items())}


@cache
def _page_text() -> str:
    told = json.dumps(words(), ensure_ascii=False).replace("<", "\\u003c")
    return _part_folder("studio.html").read_text(encoding="utf-8").replace("{{ words }}", told)


@cache
def _part_bytes() -> dict[str, tuple[bytes, str]]:
    found = {}
    for folder in PART_FOLDERS:
        for file in _part_folder(folder).iterdir():
            suffix = file.name[file.name.rfind(".") :]
            if suffix in MEDIA_TYPES and file.name != "entry.js":
                name = f"{folder}/{file.name}".lstrip("/")
                found[name] = file.read_bytes(), MEDIA_TYPES[suffix]
    return found


def _part_folder(name: str) -> Traversable:
    here = files("assistant").joinpath("studio")
    return here.joinpath(name) if name else here


PAGE_ROUTES: Final = (Route("/", page), Route("/parts/{name:path}", page_part))

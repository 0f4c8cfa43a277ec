"""Installation: the origin of this copy, and the command that adds an extra to it.

No index has the package, so a command never asks one for it by its name alone: it names the
folder, the wheel or the address that this copy came from, or the libraries of the extra.
"""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shlex
import shutil
import sys
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Severity

_NAME: Final = "robot-assistant"
_PACKAGE: Final = FilePath(__file__).parent.parent
_REQUIREMENT: Final = re.compile(r"\s*([^;]+?)\s*(?:;\s*(.*))?$")
_EXTRA: Final = re.compile(r"""extra\s*==\s*['"]([\w-]+)['"]""")
_OWN: Final = re.compile(rf"{_NAME}\[([\w, -]+)\]")


@dataclass(frozen=True, slots=True)
class ExtraRule(Rule):
    """A rule about a library that is missing; its cure holds the command that installs it.

    extra: that brings the library, several separated by commas.
    """

    extra: str = ""

    def __call__(self, **fields: Any) -> Diagnostic:
        # `super` does not know a class that slots have made anew.
        return Rule.__call__(self, **{"install": install_command(self.extra), **fields})


def missing_extra(
    code: str, message: str, extra: str, cure: str = "install it with `{install}`"
) -> ExtraRule:
    """Return the rule of an error: `{install}` of its cure is the command for this copy."""
    return ExtraRule(code, Severity.ERROR, message, cure, extra=extra)


def install_command(extra: str, *, package: FilePath = _PACKAGE, prefix: str = sys.prefix) -> str:
    """Return the command that installs an extra of this copy, in this environment.

    extra: one, or several separated by commas. package: folder of the running copy. prefix: of the
    environment.
    """
    wanted = [_quoted(one) for one in _sources(extra, package)]
    if (FilePath(prefix) / "pipx_metadata.json").is_file():
        return " ".join(["pipx", "runpip", _NAME, "install", *wanted])
    if importlib.util.find_spec("pip") is None:
        return " ".join(["uv", "pip", "install", "--python", _quoted(sys.executable), *wanted])
    return " ".join([_python(), "-m", "pip", "install", *wanted])


def _sources(extra: str, package: FilePath) -> list[str]:
    """Return the arguments for pip: the origin of this copy, or the libraries of the extra."""
    root = package.parent
    if (root / "pyproject.toml").is_file():
        return ["--editable", f"{root}[{extra}]"]
    # Only what is missing needs these: they load the network's libraries.
    from importlib import metadata
    from urllib.parse import unquote, urlsplit
    from urllib.request import url2pathname

    try:
        copy = metadata.distribution(_NAME)
    except metadata.PackageNotFoundError:
        return [f"{root}[{extra}]"]
    url = json.loads(copy.read_text("direct_url.json") or "{}").get("url", "")
    parts = urlsplit(url)
    if parts.scheme == "file":
        place = FilePath(url2pathname(unquote(parts.path) if os.name != "nt" else parts.path))
        if place.exists():
            return [f"{place}[{extra}]"]
    elif parts.scheme:
        vcs = json.loads(copy.read_text("direct_url.json") or "{}").get("vcs_info", {}).get("vcs")
        return [f"{_NAME}[{extra}] @ {f'{vcs}+' if vcs else ''}{url}"]
    return _libraries(extra, copy.requires or [])


def _libraries(extra: str, requires: list[str]) -> list[str]:
    """The requirements of extras, without the package itself."""
    found: dict[str, None] = {}
    open_, known = extra.split(","), set[str]()
    while open_:
        name = open_.pop().strip()
        known.add(name)
        for line in requires:
            parts = _REQUIREMENT.match(line)
            marker = _EXTRA.search(parts[2] or "") if parts else None
            if parts is None or marker is None or marker[1] != name:
                continue
            own = _OWN.match(parts[1])
            if own is None:
                found[parts[1]] = None
            else:
                open_ += [one for one in own[1].split(",") if one.strip() not in known]
    return list(found)


def _python() -> str:
    """`python` if that is this environment's, else the path of its interpreter."""
    found = shutil.which("python")
    same = found is not None and FilePath(found).parent == FilePath(sys.executable).parent
    return "python" if same else _quoted(sys.executable)


def _quoted(text: str) -> str:
    if os.name == "nt":
        return f'"{text}"' if re.search(r"[^\w./:\\=-]", text) else text
    return shlex.quote(text)

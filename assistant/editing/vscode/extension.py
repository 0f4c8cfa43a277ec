"""VS Code extension: its files, TextMate grammars, and the package that VS Code installs.

Grammars for colours without a server are made of the words of a language.
"""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterable, Iterator
from importlib.resources import files
from typing import Any, Final
from xml.sax.saxutils import escape

from assistant import languages
from assistant.editing.language_adapter import PSEUDO, LanguageAdapter, adapter_of
from assistant.program.editor_support import Editable

_SCOPES: Final = {
    "keyword": "keyword.control",
    "type": "storage.type",
    "instruction": "support.function.instruction",
    "function": "support.function",
    "variable": "variable.language",
    "target": "variable.language",
}
"""Sorts of known words by what colour themes know."""


def _textmate_grammar(spoken: LanguageAdapter, id: str) -> dict[str, Any]:
    """The grammar of a language as VS Code and others read it. id: of the language there."""
    editable = spoken.editable
    assert editable is not None
    patterns = [
        {"name": f"{name}.{id}", "match": match} for name, match in _plain_patterns(editable)
    ]
    return {
        "name": spoken.title,
        "scopeName": _textmate_scope(id),
        "patterns": patterns,
    }


def _textmate_scope(id: str) -> str:
    return f"source.{id}"


def _plain_patterns(editable: Editable) -> Iterator[tuple[str, str]]:
    yield from editable.colours().items()
    sorts: dict[str, list[str]] = {}
    for known in editable.known().values():
        sorts.setdefault(_SCOPES[known.sort], []).append(known.name)
    case = "(?i)" if editable.folds else ""
    for name in dict.fromkeys(_SCOPES.values()):
        if sorts.get(name):
            yield name, f"{case}{_words_pattern(sorts[name])}"
    yield "keyword.operator", r"<>|<=|>=|:=|[-+*/=<>]"


def _words_pattern(words: Iterable[str]) -> str:
    """One of some words, whole; the longest first, as one may begin another."""
    listed = sorted({*words}, key=lambda word: (-len(word), word))
    spelled = (r"\s+".join(map(re.escape, word.split())) for word in listed)
    return rf"(?<![A-Za-z0-9_])(?:{'|'.join(spelled)})(?![A-Za-z0-9_])"


NAME: Final = "robot-assistant"
_ABOUT: Final = (
    "Findings with quick fixes, names, outline and layout of robot programs, and a debugger."
)
_NEEDS: Final = (
    "It runs the command `robot-assistant`, which is installed from its folder or its wheel:"
    " `python -m pip install '.[lsp]'`."
)
_ENGINE: Final = "^1.82.0"
"""The oldest VS Code that the bundled client runs in."""
FORMAT: Final = "http://schemas.microsoft.com/developer/vsx-schema/2011"
"""Name of the manifest's format; the address is never requested."""
_TIME: Final = (1980, 1, 1, 0, 0, 0)
_TYPES: Final = {
    "json": "application/json",
    "js": "application/javascript",
    "md": "text/markdown",
    "txt": "text/plain",
    "vsixmanifest": "text/xml",
}


def packed(version: str) -> bytes:
    """The extension as a .vsix file; the same version gives the same bytes."""
    held = {
        "extension.vsixmanifest": _manifest(version),
        "[Content_Types].xml": _content_types(),
        **{f"extension/{name}": text for name, text in extension(version).items()},
    }
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in held.items():
            entry = zipfile.ZipInfo(name, _TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, text)
    return made.getvalue()


def extension(version: str) -> dict[str, str]:
    """Text of each file of the extension, by its path."""
    client = files("assistant.editing.vscode").joinpath("client")
    made = {
        "package.json": _json(package(version)),
        "client.js": client.joinpath("client.js").read_text("utf-8"),
        "LICENSE.txt": client.joinpath("LICENSE").read_text("utf-8"),
        "README.md": f"# Robot Assistant\n\n{_ABOUT}\n\n{_NEEDS}\n",
    }
    for id, one in _spoken().items():
        made[f"syntaxes/{id}.json"] = _json(_textmate_grammar(one, id))
        made[f"languages/{id}.json"] = _json(_configuration(one))
    return made


def package(version: str) -> dict[str, Any]:
    """Return the manifest of the extension."""
    known = _spoken()
    number = re.match(r"\d+\.\d+\.\d+", version)
    return {
        "name": NAME,
        "displayName": "Robot Assistant",
        "description": _ABOUT,
        "publisher": NAME,
        "version": number[0] if number else "0.0.0",
        "license": "SEE LICENSE IN LICENSE.txt",
        "engines": {"vscode": _ENGINE},
        "categories": ["Programming Languages", "Debuggers", "Formatters", "Linters"],
        "main": "./client.js",
        "activationEvents": [*(f"onLanguage:{id}" for id in known), "onDebug"],
        "capabilities": {
            "untrustedWorkspaces": {
                "supported": "limited",
                "description": "The command that is run is never taken from a folder.",
                "restrictedConfigurations": ["robotAssistant.command"],
            }
        },
        "contributes": {
            "languages": [_language(id, one) for id, one in known.items()],
            "grammars": [
                {"language": id, "scopeName": _textmate_scope(id), "path": f"./syntaxes/{id}.json"}
                for id in known
            ],
            "commands": [
                {
                    "command": "robotAssistant.showTranslation",
                    "title": "Robot Assistant: Show in Another Language",
                }
            ],
            "configuration": {
                "title": "Robot Assistant",
                "properties": {
                    "robotAssistant.command": {
                        "type": "string",
                        "scope": "machine",
                        "default": NAME,
                        "description": "The command that answers: its name, or where it is.",
                    }
                },
            },
            "breakpoints": [{"language": id} for id in known if id != PSEUDO],
            "debuggers": [_debugger([id for id in known if id != PSEUDO])],
        },
    }


def _spoken() -> dict[str, LanguageAdapter]:
    """Languages that tell editors of themselves, by their names."""
    found = {name: adapter_of(name) for name in (*languages.names(), PSEUDO)}
    return {name: one for name, one in found.items() if one is not None and one.editable}


def _language(id: str, one: LanguageAdapter) -> dict[str, Any]:
    """Suffixes that several dialects share are the first one's; the server looks at the text."""
    taken: set[str] = set()
    for name, other in _spoken().items():
        if name == id:
            break
        taken |= {*other.suffixes}
    return {
        "id": id,
        "aliases": [one.title],
        "extensions": [suffix for suffix in one.suffixes if suffix not in taken],
        "configuration": f"./languages/{id}.json",
    }


def _configuration(one: LanguageAdapter) -> dict[str, Any]:
    """Comments, brackets and indentation."""
    editable = one.editable
    assert editable is not None
    case = "(?i)" if editable.folds else ""
    opening = "|".join(re.escape(word) for word, _ in editable.blocks)
    closing = "|".join(dict.fromkeys(re.escape(word) for _, word in editable.blocks))
    pairs = [list(pair) for pair in editable.brackets]
    return {
        "comments": {"lineComment": one.mark},
        "brackets": pairs,
        "autoClosingPairs": [*pairs, ['"', '"']],
        "surroundingPairs": [*pairs, ['"', '"']],
        "indentationRules": {
            "increaseIndentPattern": {"pattern": rf"^\s*(?:{opening})\b.*$", "flags": case[2:3]},
            "decreaseIndentPattern": {"pattern": rf"^\s*(?:{closing})\b.*$", "flags": case[2:3]},
        },
    }


def _debugger(known: list[str]) -> dict[str, Any]:
    texts = {
        "program": "A file, or a folder with the modules of a task.",
        "robot": "The arm: a name of the catalogue, or a robot file.",
        "language": "Of the program, where its name does not tell.",
        "signals": "A file of inputs that change by themselves.",
        "entry": "The routine to begin with.",
    }
    said: dict[str, Any] = {
        name: {"type": "string", "description": about} for name, about in texts.items()
    }
    said["maxSteps"] = {"type": "integer", "description": "Statements after which it is over."}
    said["stopOnEntry"] = {"type": "boolean", "description": "Held before its first statement."}
    first = {"type": "robot", "request": "launch", "name": "This program", "program": "${file}"}
    return {
        "type": "robot",
        "label": "Robot program",
        "languages": known,
        "configurationAttributes": {"launch": {"required": ["program"], "properties": said}},
        "initialConfigurations": [{**first, "stopOnEntry": True}],
    }


def _json(said: dict[str, Any]) -> str:
    return json.dumps(said, indent=2, ensure_ascii=False) + "\n"


def _manifest(version: str) -> str:
    said = package(version)
    properties = {
        "Microsoft.VisualStudio.Code.Engine": _ENGINE,
        "Microsoft.VisualStudio.Code.ExtensionDependencies": "",
        "Microsoft.VisualStudio.Code.ExtensionKind": "workspace",
    }
    listed = "".join(f'<Property Id="{id}" Value="{value}"/>' for id, value in properties.items())
    assets = {
        "Microsoft.VisualStudio.Code.Manifest": "extension/package.json",
        "Microsoft.VisualStudio.Services.Content.Details": "extension/README.md",
        "Microsoft.VisualStudio.Services.Content.License": "extension/LICENSE.txt",
    }
    named = "".join(
        f'<Asset Type="{type}" Path="{path}" Addressable="true"/>' for type, path in assets.items()
    )
    return (
        '<?xml version="1.0" encoding="utf-8"?>'
        f'<PackageManifest Version="2.0.0" xmlns="{FORMAT}"><Metadata>'
        f'<Identity Language="en-US" Id="{NAME}" Version="{said["version"]}" Publisher="{NAME}"/>'
        f"<DisplayName>{escape(said['displayName'])}</DisplayName>"
        f'<Description xml:space="preserve">{escape(_ABOUT)}</Description>'
        f"<Categories>{','.join(said['categories'])}</Categories>"
        f"<Properties>{listed}</Properties><License>extension/LICENSE.txt</License></Metadata>"
        '<Installation><InstallationTarget Id="Microsoft.VisualStudio.Code"/></Installation>'
        f"<Dependencies/><Assets>{named}</Assets></PackageManifest>"
    )


def _content_types() -> str:
    named = "".join(
        f'<Default Extension=".{suffix}" ContentType="{type}"/>' for suffix, type in _TYPES.items()
    )
    space = "http://schemas.openxmlformats.org/package/2006/content-types"
    return f'<?xml version="1.0" encoding="utf-8"?><Types xmlns="{space}">{named}</Types>'

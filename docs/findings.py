"""Prints `findings.md`, the table of everything that can be found, from the rules themselves.

python -m docs.findings > docs/findings.md
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
from collections.abc import Iterator
from typing import Any

import assistant
from assistant.program.diagnostics import Rule

FAMILIES = {
    "CK": "Checks of programs",
    "CL": "Command line",
    "CN": "Controllers",
    "CO": "Compiling and proving",
    "CT": "Contours and process files",
    "DP": "Deployment",
    "DX": "Drawings",
    "IN": "Reading files",
    "MB": "MELFA-BASIC",
    "NM": "Names",
    "PS": "Pseudo-program text",
    "RA": "RAPID",
    "RB": "Robots",
    "SR": "Sources",
    "TB": "Tables and waypoints",
    "VC": "Virtual controllers",
}


def rules() -> dict[str, Rule]:
    """Every rule of the package by code; raises ValueError if two rules share a code."""
    found: dict[str, Rule] = {}
    for rule in _all_rules():
        if found.setdefault(rule.code, rule) != rule:
            raise ValueError(f"two rules have the code {rule.code}")
    return dict(sorted(found.items()))


def _all_rules() -> Iterator[Rule]:
    for module in pkgutil.walk_packages(assistant.__path__, "assistant."):
        if not module.name.endswith("__main__"):
            for value in vars(importlib.import_module(module.name)).values():
                yield from _in(value)


def _in(value: Any) -> Iterator[Rule]:
    if isinstance(value, Rule):
        yield value
    elif isinstance(value, dict):
        yield from (item for item in value.values() if isinstance(item, Rule))
    elif isinstance(value, tuple | list):
        yield from (item for item in value if isinstance(item, Rule))


def page() -> str:
    lines = [
        "# Findings",
        "",
        "Every finding has a code that stays the same. An `error` keeps anything from being",
        "written; a `warning` asks for a look; an `info` says what was done.",
    ]
    family = ""
    for code, rule in rules().items():
        if code[:2] != family:
            family = code[:2]
            lines += ["", f"## {FAMILIES[family]}", ""]
            lines += ["| code | severity | what is wrong | what to do |", "|---|---|---|---|"]
        cells = (code, str(rule.severity), rule.message, rule.cure)
        lines.append(
            "| " + " | ".join(c.replace("|", "\\|").replace("\n", " ") for c in cells) + " |"
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page())

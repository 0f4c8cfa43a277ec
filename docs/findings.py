"""Prints `findings.md`, a page about everything that can be found, from the rules themselves.

python -m docs.findings > docs/findings.md
"""

from __future__ import annotations

import sys

from assistant.findings.rulebook import families, rules, section

HEAD = """\
# Findings

Every finding has a code that stays the same. An `error` keeps anything from being written; a
`warning` asks for a look; an `info` says what was done, or what might be better. Words in
CAPITALS stand for what a finding itself names. `robot-assistant explain CODE` prints what this
page says about one. [Checking programs in CI](ci.md) tells how to give a finding another
severity, and how to ignore one where it stands.
"""


def page() -> str:
    """The families, then for each a table of its rules and a section about every one of them."""
    links = (f"| {family} | [{title}](#{_anchor(title)}) |" for family, title in families().items())
    parts = ["\n".join([HEAD, "| codes | about |", "|---|---|", *links, ""])]
    for family, title in families().items():
        own = [rule for code, rule in rules().items() if code.startswith(family)]
        rows = [
            f"| [{rule.code}](#{rule.code.lower()}) | {rule.severity} | "
            f"{_cell(rule.sentence(rule.message))} |"
            for rule in own
        ]
        table = ["| code | severity | what is wrong |", "|---|---|---|", *rows]
        parts.append("\n".join([f"## {title}", "", *table, ""]))
        parts += map(section, own)
    return "\n".join(parts)


def _anchor(title: str) -> str:
    return title.lower().replace(" ", "-")


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


if __name__ == "__main__":
    sys.stdout.write(page())

"""Every rule of the package by its code, and the page about each."""

from __future__ import annotations

import importlib
import importlib.resources
import pkgutil
import re
import string
from collections.abc import Iterator, Mapping, Sequence, Set
from functools import cache
from itertools import chain
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import assistant
from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule, Severity, error
from assistant.languages import Language

_OWN_FAMILIES: Final = {
    "BL": "Blocks and generated code",
    "CK": "Checks of programs",
    "CL": "Command line",
    "CN": "Controllers",
    "CO": "Compiling and proving",
    "CT": "Contours and process files",
    "DP": "Deployment",
    "DX": "Drawings",
    "ED": "Editing",
    "FN": "Severities and ignored findings",
    "IN": "Reading files",
    "LM": "Limits",
    "LN": "Learned and calibrated arms",
    "NM": "Names",
    "PR": "Projects",
    "PS": "Pseudo-program text",
    "RB": "Robots",
    "SR": "Sources",
    "ST": "The studio",
    "TB": "Tables and waypoints",
    "VC": "Virtual controllers",
    "VS": "Cameras and what they see",
}
"""Those that are of no language."""

PAGES: Final = "https://github.com/robot-assistant/robot-assistant/blob/main/docs/findings.md"
_NO_RULE: Final = error(
    "FN001",
    "there is no finding `{code}`",
    "write a code as findings show it, such as RA204; docs/findings.md lists all",
)


_DEFINITION: Final = re.compile(
    rb'\b(?:Rule|error|warning|info|missing_extra)\((?:\s|#.*\n)*"([A-Z]{2}[0-9]{3})"'
)
"""What defines a rule, in the text of a module."""
_CURE_OF_ITS_OWN: Final = "follow the cure below the message, as it depends on the case"


@dataclass(frozen=True, slots=True)
class Page:
    """Text about a rule beyond its row in the table.

    cure: what to do, for rules whose findings each have a cure of their own. why: how a controller
    reacts to it, or the source of a limit. example: the text of a small file that has the finding.
    better: the same file without it.
    """

    cure: str = ""
    why: str = ""
    example: str = ""
    better: str = ""


def families() -> Mapping[str, str]:
    """The letters that codes begin with → what the family is about, those of languages as well."""
    spoken = map(languages.get, languages.names())
    theirs = {one.family: one.family_title or one.title for one in spoken}
    return dict(sorted({**_OWN_FAMILIES, **theirs}.items()))


@cache
def pages() -> Mapping[str, Page]:
    """Return the pages about rules, by code: one file of `pages/` for each family that has one."""
    folder = importlib.resources.files("assistant.findings") / "pages"
    files = sorted(folder.iterdir(), key=lambda file: file.name)
    import tomllib

    tables = [tomllib.loads(file.read_text(encoding="utf-8")) for file in files]
    return {code: Page(**page) for table in tables for code, page in table.items()}


def rule_of(code: str) -> Rule | None:
    """Return the rule of a code, None if there is none. Imports the modules that define it."""
    for name in _modules_by_code().get(code, ()):
        rules = chain.from_iterable(map(_in, vars(importlib.import_module(name)).values()))
        if (rule := next((rule for rule in rules if rule.code == code), None)) is not None:
            return rule
    return None


def codes() -> Set[str]:
    """Return the codes of all rules."""
    return _modules_by_code().keys()


@cache
def _modules_by_code() -> Mapping[str, Sequence[str]]:
    """Return names of modules by the codes whose rules their texts define, without an import."""
    package = Path(assistant.__path__[0])
    found: dict[str, list[str]] = {}
    for file in sorted(package.rglob("*.py")):
        for code in _DEFINITION.findall(file.read_bytes()):
            module = ".".join(file.relative_to(package.parent).with_suffix("").parts)
            found.setdefault(code.decode(), []).append(module.removesuffix(".__init__"))
    return found


@cache
def rules() -> Mapping[str, Rule]:
    """Every rule by code; raises ValueError if two rules share one. Imports all of the package."""
    found: dict[str, Rule] = {}
    for rule in rules_in(assistant):
        if found.setdefault(rule.code, rule) != rule:
            raise ValueError(f"two rules have the code {rule.code}")
    return dict(sorted(found.items()))


def rules_in(package: ModuleType) -> Iterator[Rule]:
    """Every rule in a package, some several times. Imports all of it."""
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not module.name.endswith("__main__"):
            try:
                members = vars(importlib.import_module(module.name))
            except ModuleNotFoundError as error:
                if (error.name or "").startswith(package.__name__):
                    raise
                continue  # a module that needs an optional package has no say without it
            for value in members.values():
                yield from _in(value)


def page_address(code: str) -> str:
    """Return the address of the page about a code."""
    return f"{PAGES}#{code.lower()}"


def explain(codes: Sequence[str]) -> str:
    """Return the pages of the rules with these codes; raises Refused for an unknown code."""
    found = {code: rule_of(code.upper()) for code in codes}
    if unknown := [code for code, rule in found.items() if rule is None]:
        raise Refused(*(_NO_RULE(code=code) for code in unknown), exit_status=2)
    return "\n".join(section(rule) for code in codes if (rule := found[code]))


def cure_in_general(rule: Rule) -> str:
    """What to do about the findings of a rule, to be read without one; empty if nothing."""
    if cure := pages().get(rule.code, Page()).cure:
        return " ".join(cure.split())
    words = "".join(text for text, *_ in string.Formatter().parse(rule.cure))
    named = any(c.isalpha() for c in words)
    return rule.sentence(rule.cure) if named or not rule.cure else _CURE_OF_ITS_OWN


def section(rule: Rule) -> str:
    """The page about a rule, in Markdown: what is wrong, what to do, why, and an example."""
    page = pages().get(rule.code, Page())
    lines = [f"### {rule.code}", "", f"**{rule.severity}**: {rule.sentence(rule.message)}", ""]
    if cure := cure_in_general(rule):
        lines += [f"What to do: {cure}", ""]
    if page.why:
        lines += [page.why.strip(), ""]
    for title, text in (("For example", page.example), ("Better", page.better)):
        if text:
            lines += [f"{title}:", "", "```text", text.strip("\n"), "```", ""]
    return "\n".join(lines)


def adjustable(rule: Rule) -> bool:
    """True if a project may give the rule a lower severity, or ignore it.

    This holds for all warnings and infos. It holds for errors only if a language's check of a
    program reports them; other errors report text that cannot be read, or the reason why no file is
    written.
    """
    return rule.severity is not Severity.ERROR or _is_check(rule.code)


def is_adjustable(finding: Diagnostic) -> bool:
    """The same for a finding, which may be worse than its rule usually is."""
    return finding.severity is not Severity.ERROR or _is_check(finding.code)


def language_of(code: str) -> Language[Any] | None:
    """The first language whose family a code is of."""
    spoken = map(languages.get, languages.names())
    return next((language for language in spoken if code.startswith(language.family)), None)


def _is_check(code: str) -> bool:
    language = language_of(code)
    return language is not None and not code.startswith(language.fixed)


def _in(value: Any) -> Iterator[Rule]:
    if isinstance(value, Rule):
        yield value
    elif isinstance(value, dict):
        yield from (item for item in value.values() if isinstance(item, Rule))
    elif isinstance(value, tuple | list):
        yield from (item for item in value if isinstance(item, Rule))

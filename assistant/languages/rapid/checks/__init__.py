"""Rules of RAPID over the modules of one program: what a controller would refuse.

`CHECKS` lists every rule. The modules are one task's unless their folders and files are named like
several tasks; findings that only follow from a syntax error are left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import PurePosixPath
from typing import Final

from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.languages.checks import registry
from assistant.languages.checks.registry import Check, Damage, Needs, findings, undamaged_findings
from assistant.languages.rapid.checks import declarations, flow, motions, records, uses
from assistant.languages.rapid.checks.rule_context import RuleContext, Task
from assistant.languages.rapid.checks.single_rows import with_single_rows
from assistant.languages.rapid.tables.constants import RESERVED
from assistant.languages.rapid.tables.predefined import taken_names
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes

_MOST_STATEMENT_LINES: Final = 51
"""Maximum lines of one statement; a finding on a longer stretch marks a complete routine or table,
not one damaged position.
"""
_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KNOWN_WORDS: Final = RESERVED | taken_names()


def _damage_of(trees: Sequence[s.File]) -> Damage | None:
    """Return the damage in the modules of a program, None if nothing is damaged.

    The lines next to a damaged line count as damaged too, and so do names that a blank may have
    split in two.
    """
    return registry.damage_of(
        trees,
        _unknown_words,
        hidden=_joined_words,
        near=1,
        most_lines=_MOST_STATEMENT_LINES,
        named_lines=1,
    )


def _joined_words(text: str) -> Iterator[str]:
    """Yield each pair of neighbouring names joined into one, in lower case."""
    yield from ((one + other).lower() for one, other in pairwise(_NAME.findall(text)))


def _unknown_words(text: str) -> Iterator[str]:
    """Yield the names in a text that are not words of the language, in lower case."""
    for word in _NAME.findall(text):
        if word.lower() not in _KNOWN_WORDS:
            yield word.lower()


_TASK_NAME: Final = re.compile(r"(?:T_\w+|TASK\d+)", re.IGNORECASE)
"""Folders that a controller names after its tasks: `T_ROB1`, `TASK1` in a backup."""
_ARM_NAME: Final = re.compile(r"(.+?)([Ll]eft|[Rr]ight|(?<![A-Za-z])[LRlr]|(?<=[a-z])[LR])(_?\d*)")
"""Names of the files of a robot with two arms, each of which is a task."""
_COMMON_TASKS: Final = ("", "task0")
"""No task, and the folder of a backup with the modules that every task has."""


TaskFiles = tuple[s.File, ...]


def tasks(files: Sequence[s.File]) -> Iterator[tuple[TaskFiles, TaskFiles]]:
    """The files of each task, and those among them that are of every task.

    One task with all files if no names of folders or files tell several apart.
    """
    paths = [PurePosixPath((file.path or "").replace("\\", "/")) for file in files]
    arms = _arms(paths)
    named = [_task_of_path(path) or arms.get(path.stem, "") for path in paths]
    names = [name for name in dict.fromkeys(named) if name not in _COMMON_TASKS]
    # One name tells nothing apart: a single task may have files in folders of any name.
    if len(names) < 2:
        yield tuple(files), ()
        return
    common = tuple(file for file, of in zip(files, named, strict=True) if of in _COMMON_TASKS)
    for name in names:
        yield (
            tuple(f for f, of in zip(files, named, strict=True) if of in (name, *_COMMON_TASKS)),
            common,
        )


def _task_of_path(path: PurePosixPath) -> str:
    """The task that a path names: its innermost folder that is named like one, else the file."""
    # The innermost folder is the most specific, and a folder counts more than a file.
    names = [*reversed(path.parts[:-1]), path.stem]
    return next((name.lower() for name in names if _TASK_NAME.fullmatch(name)), "")


def _arms(paths: Sequence[PurePosixPath]) -> dict[str, str]:
    """`l` or `r` by the name of each file that has a counterpart for the other arm."""
    sides = [(path.stem, match) for path in paths if (match := _ARM_NAME.fullmatch(path.stem))]
    found: dict[tuple[str, str], set[str]] = {}
    for _, match in sides:
        found.setdefault((match[1], match[3]), set()).add(match[2][0].lower())
    # A name with a side but without its counterpart is an ordinary name.
    return {stem: m[2][0].lower() for stem, m in sides if len(found[m[1], m[3]]) == 2}


__all__ = ["CHECKS", "check", "loaded_files"]

CHECKS: Final[tuple[Check[RuleContext], ...]] = (
    Check(declarations.module_names, Needs.ORDER),
    Check(declarations.duplicate_names),
    Check(declarations.name_spelling),
    Check(flow.declarations, Needs.ORDER),
    Check(flow.handlers, Needs.ORDER),
    Check(declarations.storage_places, Needs.ORDER),
    Check(declarations.initial_values),
    Check(declarations.array_dimensions),
    Check(declarations.read_only_data),
    Check(declarations.traps_and_aliases),
    Check(declarations.string_lengths),
    Check(declarations.number_sizes),
    Check(records.quaternion_lengths),
    Check(records.configurations),
    Check(motions.motion_names),
    Check(records.equipment_values, Needs.ORDER),
    Check(records.held_pairs, Needs.ORDER),
    Check(motions.unset_triggers, Needs.ORDER),
    Check(motions.long_trigger_times),
    Check(uses.uses_by_construct),
    Check(flow.jumps, Needs.ORDER),
    Check(flow.outside_handlers, Needs.ORDER),
    Check(flow.never_booked, Needs.ORDER),
    Check(flow.returns, Needs.ORDER),
    Check(flow.unreachable, Needs.ORDER),
    Check(flow.cases_and_steps, Needs.ORDER),
    Check(declarations.undeclared_names),
    Check(motions.arcs, Needs.ORDER, advice=True),
    Check(motions.endless_waits, advice=True),
    Check(motions.signals_on_the_fly, advice=True),
    Check(declarations.unused_declarations, Needs.ORDER, advice=True),
)
"""Each looks at one module, and sees what the modules beside it declare."""


def check(trees: Sequence[s.File]) -> tuple[Diagnostic, ...]:
    """Findings of the parser and of every rule, over the modules of a program.

    They are one task's, unless their folders are named like several tasks. What may follow from
    a syntax error is left out.
    """
    found = [finding for tree in trees for finding in tree.findings]
    damage = _damage_of(trees)
    for files, common in tasks(trees):
        # Rows with something to report become nodes of their own, so that rules need not look into
        # runs.
        single = with_single_rows(files, common)
        shared = {id(one) for one in common}
        pairs = zip(files, single, strict=True)
        task = Task(single, [new for old, new in pairs if id(old) in shared])
        for tree in single:
            lacks = Needs.ORDER if has_errors(tree.findings) else Needs.NOTHING
            for module in tree.modules:
                look = RuleContext(tree, module, task)
                of_module = findings(CHECKS, look, lacks, compiled=look.compiled)
                found += undamaged_findings(of_module, damage, tree.source)
    # Modules that several tasks share give the same findings in each.
    return tuple(dict.fromkeys(found))


def loaded_files(root: s.File) -> tuple[str, ...]:
    """Names of the files that `Load` instructions with a literal path name."""
    files = [
        first.value.value.replace(":", "/").rsplit("/", 1)[-1]
        for call in nodes(root.modules)
        if isinstance(call, s.ProcedureCall) and str(call.name).lower() == "load"
        for first in call.arguments
        if isinstance(first, s.Positional) and isinstance(first.value, s.StringLiteral)
    ]
    return tuple(sorted(set(files)))

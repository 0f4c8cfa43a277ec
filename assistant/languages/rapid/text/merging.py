"""Changes of a program made in the tree that it was lifted from.

Lifting and building lose layout, order and spelling. So a changed program is built twice, as it
was lifted and as it is now: what differs between the two is changed in the tree as well, and all
the rest of the tree stays as people wrote it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from typing import Any

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.texts import tree_merge

ItemKey = tuple[str, str]


def merge(tree: s.File, before: s.File, after: s.File) -> s.File:
    """The tree with everything changed that differs between two built trees.

    `after` itself where a change is in something that the tree does not have in that form.
    """
    if not all(len(file.modules) == 1 for file in (tree, before, after)):
        return after
    (module,), (old,), (new,) = tree.modules, before.modules, after.modules
    merged = tree_merge.merged_by_key(
        module.items, old.items, new.items, _item_key, changed=_merged_routine, place=_place_of_item
    )
    if merged is None:
        return after
    items = _with_comments(merged, _comment_texts(old.items), _comment_texts(new.items))
    name = module.name if old.name == new.name else new.name
    changed = replace(module, name=name, items=items)
    return replace(tree, parts=tuple(changed if part is module else part for part in tree.parts))


def _item_key(item: Any) -> ItemKey | None:
    """Kind and lower-case name of what a module declares; a run is known by its first row."""
    match item:
        case s.TargetRunNode(_, run):
            return "data", run.names.name(0).lower()
        case s.Data(name=name):
            return "data", name.lower()
        case s.Routine(name=name):
            return "routine", name.lower()
        case s.Record(name=name) | s.Alias(name=name):
            return "type", name.lower()
    return None


def _merged_routine(here: Any, old: Any, new: Any) -> Any:
    """The new item, in a routine with the statements that did not change as they stand here."""
    if not isinstance(here, s.Routine) or len(here.body) != len(old.body):
        return new
    steps = SequenceMatcher(None, old.body, new.body, autojunk=False).get_opcodes()
    body: list[s.StatementNode] = []
    for step, first, last, start, stop in steps:
        body += here.body[first:last] if step == "equal" else new.body[start:stop]
    heads = (replace(old, body=()), replace(new, body=()))
    return replace(here if heads[0] == heads[1] else new, body=tuple(body))


def _place_of_item(items: Sequence[s.Item], new: Any) -> int:
    """Behind the last item of its kind; data before the first routine."""
    data = isinstance(new, s.Data | s.TargetRunNode)
    kinds: Any = (s.Data, s.TargetRunNode) if data else type(new)
    places = [at + 1 for at, item in enumerate(items) if isinstance(item, kinds)]
    if places:
        return places[-1]
    routines = [at for at, item in enumerate(items) if isinstance(item, s.Routine)]
    return routines[0] if routines and not isinstance(new, s.Routine) else len(items)


def _comment_texts(items: Iterable[s.Item]) -> list[str]:
    return [item.text for item in items if isinstance(item, s.CommentLine)]


def _with_comments(items: Sequence[s.Item], old: list[str], new: list[str]) -> tuple[s.Item, ...]:
    """Comments that came stand first; those that went are gone wherever they stood."""
    gone = [text for text in old if text not in new]
    came = [s.CommentLine(text) for text in new if text not in old]
    kept = [i for i in items if not (isinstance(i, s.CommentLine) and i.text in gone)]
    return (*came, *kept)

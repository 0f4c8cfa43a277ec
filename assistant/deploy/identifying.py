"""Which controller it is: that of the project, of the plan, of the journal."""

from __future__ import annotations

import re
from typing import Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.record import Record, plain_text

NAME_WORD: Final = re.compile(r"\d+(?:\.\d+)?|[a-z]+")
CLOSE_FIGURES: Final = 0.05
"""By how much two figures of a robot's name may differ: a reach of 0.58 m is also told as 0.6."""


def check_meant(identity: Identity | None, meant: Identity, place: str) -> tuple[Diagnostic, ...]:
    """Refuses another controller than the one that a project means, serial number and robot.

    Comes back with a warning of a serial number that cannot be told. Many a project names the
    robot only to compile for it: one that is not told is passed over.
    """
    told = identity or Identity()
    refused: list[Diagnostic] = []
    if _is_model(told.robot) and meant.robot and not same_robot(meant.robot, told.robot):
        refused.append(
            rules.NOT_MEANT(place=place, what="the robot", wanted=meant.robot, told=told.robot)
        )
    what, wanted, there = "the serial number", meant.serial.strip(), told.serial.strip()
    if wanted and there and wanted.casefold() != there.casefold():
        refused.append(rules.NOT_MEANT(place=place, what=what, wanted=wanted, told=there))
    if refused:
        raise Refused(*refused)
    return (rules.UNTOLD(place=place, what=what, wanted=wanted),) if wanted and not there else ()


def check_same(identity: Identity | None, record: Record, place: str) -> None:
    """Refuses another controller than that of a deployment, as far as both are told."""
    if _other(identity, record) is not None:
        raise Refused(rules.ANOTHER(place=place))


def of_another(identity: Identity | None, record: Record | None) -> Diagnostic | None:
    """The warning that a record was brought to this controller from another one, with its files."""
    other = None if record is None else _other(identity, record)
    if record is None or other is None:
        return None
    now, then = other
    return rules.OF_ANOTHER(place=record.name, name=record.name, now=now, then=then)


def _other(identity: Identity | None, record: Record) -> tuple[str, str] | None:
    """What is told otherwise than in a record, and what that says; what is not told is not."""
    told = identity or Identity()
    pairs = (
        (plain_text(told.robot), record.robot),
        (plain_text(told.controller), record.controller),
        (plain_text(told.serial), record.serial),
    )
    return next(((now, then) for now, then in pairs if now and then and now != then), None)


def same_robot(one: str, other: str) -> bool:
    """Whether two names mean one robot: `irb1200-7-0.7` is `IRB 1200-7/0.7`.

    The shorter name may lack what the other adds: the maker, a cable or a colour.
    """
    shorter, longer = sorted((_name_words(one), _name_words(other)), key=len)
    left = list(longer)
    for word in shorter:
        found = next((there for there in left if _similar_words(word, there)), None)
        if found is None:
            return False
        left.remove(found)
    return True


def _is_model(name: str) -> bool:
    """Whether it is a model of a maker, with letters and figures."""
    words = _name_words(name)
    return any(map(str.isalpha, words)) and not all(map(str.isalpha, words))


def _name_words(name: str) -> list[str]:
    return NAME_WORD.findall(name.lower())


def _similar_words(one: str, other: str) -> bool:
    if "." in one and "." in other:
        return abs(float(one) - float(other)) < CLOSE_FIGURES
    return one == other

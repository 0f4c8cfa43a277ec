"""What is found when ways of a program are planned: `travel to`."""

from __future__ import annotations

from assistant.base.diagnostics import error, info

TRAVEL_WITHOUT_CELL = error(
    "CK470",
    "a way to `{target}` is planned through a cell, and none is told",
    "name the file of the cell: --cell cell.toml",
)
START_UNKNOWN = error(
    "CK471",
    "where the arm is when it begins to travel to `{target}` is not known: {why}",
    "{cure}",
)
TRAVEL_FROM_SEVERAL = error(
    "CK472",
    "the way to `{target}` is not the same each time: it {what}",
    "move to one place before it, or write a `travel to` for each of them",
)
GOAL_UNKNOWN = error(
    "CK473",
    "only running the program tells where `{target}` is, so no way there can be planned",
    "travel to a target whose place the text tells",
)
TRAVEL_NOT_REACHED = error(
    "CK474",
    "no way through the program leads to `travel to {target}`, so nothing tells where it begins",
    "take it out, or call its procedure from where the program begins",
)
TRAVEL_EXTERNAL_AXES = error(
    "CK475",
    "`{target}` moves external axes, for which no way is planned",
    "move them before, and travel to a target that says nothing of them",
)
FROM_HOME = info(
    "CK476",
    "the way to `{target}` is planned from where the robot is at home, as nothing moves before it",
    "begin the program with a move to a known place, from which the way leads",
)
TRAVEL_UNDECLARED = error(
    "CK495",
    "no {what} `{name}` is declared, so no way to `{target}` can be planned",
    "declare it",
)
TRAVEL_NO_NUMBER = error(
    "CK496",
    "the `{word}` of the way to `{target}` is `{value}`, which is no number above 0 that the text "
    "tells",
    "write a number above 0",
)

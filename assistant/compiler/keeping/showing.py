"""Values of programs in a few words, for findings."""

from __future__ import annotations

from typing import Any, Final

from assistant.program.geometry import JointTarget, Target, Tool

SHOWN_DIGITS: Final = 4
LONGEST_VALUE: Final = 60


def value_text(value: Any, beside: Any = None) -> str:
    """A value as people read it. beside: another one, from which it is to be told."""
    if value is None:
        return "nothing"
    if isinstance(value, Target):
        told = numbers_text(value.pose.position)
        if isinstance(beside, Target) and beside.pose.position == value.pose.position:
            told += f" {numbers_text(value.pose.quaternion)}"
        if isinstance(beside, Target) and beside.pose == value.pose:
            return "another branch of the arm"
        return told
    if isinstance(value, JointTarget):
        return numbers_text(value.joints)
    if isinstance(value, Tool):
        same = isinstance(beside, Tool) and beside.tip.position == value.tip.position
        tip = numbers_text(value.tip.position)
        return f"{tip} {numbers_text(value.tip.quaternion)}" if same else tip
    text = str(value)
    return text if len(text) <= LONGEST_VALUE else f"{text[:LONGEST_VALUE]}…"


def numbers_text(values: Any) -> str:
    """Numbers in brackets, without those at the end that are not used."""
    listed = [float(v) for v in values]
    while listed and listed[-1] != listed[-1]:
        listed.pop()
    return f"[{', '.join(f'{round(v, SHOWN_DIGITS):g}' for v in listed)}]"

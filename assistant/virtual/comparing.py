"""Whether two programs do the same to the world, each as its own interpreter tells it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Final

import numpy as np

from assistant.program import rotations
from assistant.program.geometry import Pose
from assistant.virtual.events import (
    Event,
    Moved,
    OnWay,
    Reported,
    Run,
    Said,
    Stopped,
    Switched,
    Waited,
)

POSITION: Final = 0.02
"""mm. MELFA-BASIC has two decimals of a millimetre, so that a place is off by 0.009 at most, and
a tool or a frame by as much again; one that was read wrongly is off by far more."""
ANGLE: Final = 0.02
"""Degrees, for the same reason."""
JOINT: Final = 0.02
SPEED: Final = 1e-3
"""Of the speed itself."""
BLEND: Final = 0.01
TIME: Final = 1e-3

Bits = Mapping[str, Sequence[int]]
"""Numbers of a signal's bits, the lowest first, by its name in lower case."""


def difference(first: Run, second: Run, signals: Bits | None = None) -> str | None:
    """What the second run does that the first does not, or the other way; None if they agree.

    signals: where a name of one run is a number of the other. A signal that is set to what it is
    anyway does nothing; nor do texts, and delays of no time. A corner of the second may be
    narrower. Joints are compared where nothing tells which flange they give: two arms that stand
    alike have other ones. Speeds of joint motions are not compared: they are percentages of an
    arm's own. A run of the first that waits for ever, or ends for good, may be one without end in
    the second. Of a run that was broken off only what was told is compared.
    """
    ours = list(_doings(first, signals or {}))
    others = list(_doings(second, signals or {}))
    halted = bool(ours) and ours[-1] == Stopped(end=True)
    if halted:  # a program that must not go on may stop again and again
        ours[-1] = Stopped()
        while len(others) > len(ours) and others[-1] == Stopped():
            others.pop()
    both = (first.ended, second.ended)
    if {"steps", "unknown"} & set(both) and both != ("stopped", "steps"):
        shorter = min(len(ours), len(others))
        ours, others = ours[:shorter], others[:shorter]
    for place, (one, two) in enumerate(zip_longest(ours, others), 1):
        if one is None:
            return f"event {place}: {_end(first)}, and {_said(two)}"
        if two is None:
            return f"event {place}: {_said(one)}, and {_end(second)}"
        wrong = _unlike(one, two)
        if wrong is not None:
            return f"event {place}: {wrong}: {_said(one)}, and {_said(two)}"
    return None if halted or _end_alike(*both) else f"{_end(first)}, and {_end(second)}"


def _end_alike(first: str, second: str) -> bool:
    broken_off = {"steps", "unknown"} & {first, second}
    return first == second or bool(broken_off)


def _end(run: Run) -> str:
    return f"ended as `{run.ended}` {run.message}".rstrip()


def _doings(run: Run, signals: Bits) -> Iterator[Event]:
    """The events that count, signals as the bits that change."""
    state: dict[str, float] = {}
    named = {str(number) for numbers in signals.values() for number in numbers}
    for event in run.events:
        match event:
            case Said() | Reported() | Waited(seconds=0.0):
                continue
            case Switched(signal, value, at):
                for bit, on in _bits(signal, value, signals):
                    # A byte is written with what its other bits have, which are 0 at first.
                    before = None if bit in named or not bit.isdecimal() else 0.0
                    if state.get(bit, before) != on:
                        yield Switched(bit, on, at)
                    state[bit] = on
            case _:
                yield event


def _bits(signal: str, value: float, signals: Bits) -> Iterator[tuple[str, float]]:
    numbers = signals.get(signal)
    if numbers is None:
        yield signal, value
        return
    for place, number in enumerate(numbers):
        yield str(number), float(int(value) >> place & 1)


def _unlike(one: Event, two: Event) -> str | None:
    """What differs of two events, None if they are the same."""
    match one, two:
        case Moved(), Moved():
            return _other_motion(one, two)
        case Switched(), Switched():
            if (one.signal, one.value) != (two.signal, two.value):
                return "another event"
            return None if _same_place(one.at, two.at) else "another place on the way"
        case Waited(), Waited():
            return None if abs(one.seconds - two.seconds) <= TIME else "another delay"
    return None if one == two else "another event"


def _same_place(one: OnWay | None, two: OnWay | None) -> bool:
    if one is None or two is None:
        return one is two
    near = TIME if one.measure == "time" else POSITION
    return (
        one.measure == two.measure
        and abs(one.amount - two.amount) <= near
        and abs(one.ahead - two.ahead) <= TIME
    )


def _other_motion(one: Moved, two: Moved) -> str | None:
    if one.kind != two.kind:
        return "another kind of motion"
    if one.flange is None or two.flange is None:
        if one.joints is None or two.joints is None:
            return "joints, and a position"
        if not _near(one.joints, two.joints, JOINT):
            return "other joints"
    for what, a, b in (("flange", one.flange, two.flange), ("place on the way", one.via, two.via)):
        if (a is None) != (b is None):
            return f"no {what}"
        if a is not None and b is not None and (apart := _apart(a, b)):
            return f"another {what}, {apart}"
    if apart := _apart(one.tool, two.tool):
        return f"another tool, {apart}"
    if one.kind != "joint" and one.speed is not None:
        if two.speed is None or abs(one.speed - two.speed) > SPEED * one.speed:
            return "another speed"
    return "a wider corner" if two.blend > one.blend + BLEND else None


def _near(one: Sequence[float], two: Sequence[float], most: float) -> bool:
    return len(one) == len(two) and bool(np.all(np.abs(np.subtract(one, two)) <= most))


def _apart(one: Pose, two: Pose) -> str:
    """How far two poses are apart, empty where it is less than rounding can be."""
    far = float(np.linalg.norm(np.subtract(one.position, two.position)))
    turned = float(rotations.angle_between(one.quaternion, two.quaternion))
    if far <= POSITION and turned <= ANGLE:
        return ""
    return f"{far:.2f} mm and {turned:.2f} degrees off"


def _said(event: Event) -> str:
    match event:
        case Moved():
            where = event.joints if event.flange is None else event.flange.position
            stated = "" if where is None else ", ".join(f"{v:.2f}" for v in where)
            return f"{event.kind} to ({stated}) at {event.speed} blend {event.blend}"
        case Switched(signal, value, at):
            place = "" if at is None else f" at {at.amount:g} of {at.measure}, {at.ahead:g} s ahead"
            return f"signal {signal} = {value:g}{place}"
        case Waited(seconds):
            return f"{seconds:g} s"
        case Stopped(end):
            return "an end for good" if end else "a stop"
    return "a text"

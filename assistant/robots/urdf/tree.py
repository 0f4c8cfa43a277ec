"""Links and joints of a URDF, and the chain from its root to its flange."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.robots.urdf.elements import XmlElement

MOVING_JOINTS: Final = ("revolute", "continuous", "prismatic")
JOINT_KINDS: Final = (*MOVING_JOINTS, "fixed", "floating", "planar")
FLANGE_NAMES: Final = ("tool0", "flange")
"""Names of links that are the flange, by convention of ROS-Industrial; the first that is there."""
LARGEST: Final = 1e6
"""m, radians or these a second: the largest number that is taken for one of a robot."""
LEAST_DECIMALS: Final = 2
"""Decimals from which on an angle that is printed short of a quarter turn counts as one."""


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """xyz: m. rpy: radians. limits: radians or m, None if there are none. velocity: a second."""

    name: str
    kind: str
    parent: str
    child: str
    element: XmlElement
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    axis: tuple[float, float, float]
    limits: tuple[float, float] | None
    velocity: float | None
    rounded: bool
    follows: bool

    @property
    def moving(self) -> bool:
        return self.kind in MOVING_JOINTS


@dataclass(slots=True)
class UrdfReader:
    """Reads elements and collects what is wrong with them."""

    path: str | None
    findings: list[Diagnostic] = field(default_factory=list)

    def joint(self, element: XmlElement) -> UrdfJoint:
        name, kind = element.attributes.get("name", ""), element.attributes.get("type", "")
        if not name:
            self.wrong(element, "has no name")
        if kind not in JOINT_KINDS:
            what = f"type `{kind}` is none of {', '.join(JOINT_KINDS)}"
            self.wrong(
                element, f"has no type; there are {', '.join(JOINT_KINDS)}" if not kind else what
            )
        ends = {}
        for end in ("parent", "child"):
            part = element.first(end)
            ends[end] = "" if part is None else part.attributes.get("link", "")
            if not ends[end]:
                self.wrong(element, f"names no {end} link")
        xyz, rpy, rounded = self.origin(element)
        axis = element.first("axis")
        return UrdfJoint(
            name=name,
            kind=kind,
            parent=ends["parent"],
            child=ends["child"],
            element=element,
            xyz=xyz,
            rpy=rpy,
            axis=self.axis(element, axis) if kind in MOVING_JOINTS else (0.0, 0.0, 1.0),
            limits=self.limits(element, kind),
            velocity=self.velocity(element) if kind in MOVING_JOINTS else None,
            rounded=rounded,
            follows=element.first("mimic") is not None,
        )

    def origin(
        self, element: XmlElement
    ) -> tuple[tuple[float, float, float], tuple[float, float, float], bool]:
        """Its xyz in m and rpy in radians, and whether an angle was taken for a quarter turn."""
        origin = element.first("origin")
        xyz = self.vector(element, origin, "xyz", (0.0, 0.0, 0.0))
        rpy = self.vector(element, origin, "rpy", (0.0, 0.0, 0.0))
        texts = (origin.attributes.get("rpy", "") if origin else "").split()
        exact = tuple(map(exact_quarter_turn, rpy, texts)) if len(texts) == 3 else rpy
        return xyz, (exact[0], exact[1], exact[2]), exact != rpy

    def axis(self, joint: XmlElement, axis: XmlElement | None) -> tuple[float, float, float]:
        x, y, z = self.vector(joint, axis, "xyz", (1.0, 0.0, 0.0))
        length = math.hypot(x, y, z)
        if length < 1e-6:
            self.wrong(joint, "has an axis of length 0")
            return (0.0, 0.0, 1.0)
        return x / length, y / length, z / length

    def limits(self, joint: XmlElement, kind: str) -> tuple[float, float] | None:
        limit = joint.first("limit")
        if kind not in ("revolute", "prismatic") or limit is None:
            return None
        # What a URDF leaves out is 0.
        low, high = (self.number(joint, limit, key, 0.0) for key in ("lower", "upper"))
        if low is None or high is None:
            return None
        if not low < high:
            self.wrong(joint, f"has a lower limit of {low:g} that is not below its upper, {high:g}")
            return None
        return low, high

    def velocity(self, joint: XmlElement) -> float | None:
        limit = joint.first("limit")
        value = None if limit is None else self.number(joint, limit, "velocity", None)
        return value if value is not None and value > 0.0 else None

    def vector(
        self,
        joint: XmlElement,
        part: XmlElement | None,
        key: str,
        usual: tuple[float, float, float],
    ) -> tuple[float, float, float]:
        text = None if part is None else part.attributes.get(key)
        if part is None or text is None:
            return usual
        numbers = [_parse_number(word) for word in text.split()]
        x, y, z = numbers if len(numbers) == 3 else (None, None, None)
        if x is None or y is None or z is None:
            self.wrong(
                joint,
                f"has {key} `{text}` of <{part.tag}>, which is not three numbers up to {LARGEST:g}",
            )
            return usual
        return x, y, z

    def number(
        self, joint: XmlElement, part: XmlElement, key: str, usual: float | None
    ) -> float | None:
        text = part.attributes.get(key)
        value = usual if text is None else _parse_number(text)
        if text is not None and value is None:
            self.wrong(
                joint, f"has {key} `{text}` of <{part.tag}>, which is no number up to {LARGEST:g}"
            )
        return value

    def wrong(self, element: XmlElement, reason: str) -> None:
        self.findings.append(element.wrong(self.path, reason))

    def links(self, root: XmlElement) -> dict[str, XmlElement]:
        found: dict[str, XmlElement] = {}
        for element in root.all("link"):
            name = element.attributes.get("name", "")
            if not name:
                self.wrong(element, "has no name")
            elif name in found:
                self.wrong(element, "stands there twice")
            found[name] = element
        return found

    def tree(self, root: XmlElement) -> Mapping[str, UrdfJoint]:
        """Name of a link → the joint that carries it."""
        links = self.links(root)
        joints = [self.joint(element) for element in root.all("joint")]
        carried: dict[str, UrdfJoint] = {}
        names: set[str] = set()
        for joint in joints:
            if joint.name and joint.name in names:
                self.wrong(joint.element, "stands there twice")
            names.add(joint.name)
            for end, link in (("parent", joint.parent), ("child", joint.child)):
                if link and link not in links:
                    self.wrong(joint.element, f"has a {end} link `{link}` that is not there")
            if joint.child in carried:
                other = carried[joint.child].name
                self.wrong(joint.element, f"carries link `{joint.child}`, as does joint `{other}`")
            carried[joint.child] = joint
        if not self.findings:
            self.one_root(root, links, carried)
        return carried

    def one_root(
        self, root: XmlElement, links: Mapping[str, XmlElement], carried: Mapping[str, UrdfJoint]
    ) -> None:
        roots = [name for name in links if name not in carried]
        if len(roots) != 1:
            what = f"has {len(roots)} links that no joint carries ({', '.join(roots[:5])}), not one"
            circle = "has no link that no joint carries: it is a circle"
            self.wrong(root, what if roots or not links else circle)
            return
        hanging = {roots[0]}
        for link, _ in links_outwards(carried):
            hanging.add(link)
        for name in links:
            if name not in hanging:
                self.wrong(links[name], "hangs on itself")
                return


def joint_chain(tip: str, carried: Mapping[str, UrdfJoint]) -> tuple[UrdfJoint, ...]:
    """The joints from the root to a link."""
    return tuple(reversed(list(_path_to_root(tip, carried))))


def links_outwards(carried: Mapping[str, UrdfJoint]) -> Iterator[tuple[str, UrdfJoint]]:
    """The links that hang on a root, with the joints that carry them, each behind its parent."""
    children: dict[str, list[str]] = {}
    for link, joint in carried.items():
        children.setdefault(joint.parent, []).append(link)
    waiting = [link for root in children if root not in carried for link in children[root]]
    while waiting:
        link = waiting.pop()
        yield link, carried[link]
        waiting += children.get(link, ())


def flange_link(carried: Mapping[str, UrdfJoint]) -> tuple[str, str]:
    """The link that is the flange, and why: a name of `TIPS`, else the end with most axes."""
    counts: dict[str, tuple[int, int]] = {}
    for link, joint in links_outwards(carried):
        moving, all_ = counts.get(joint.parent, (0, 0))
        counts[link] = moving + joint.moving, all_ + 1

    def axes(link: str) -> int:
        return counts[link][0]

    for wanted in FLANGE_NAMES:
        named = [link for link in carried if _is_called(link, wanted) and axes(link)]
        if named:
            return max(named, key=lambda link: (link == wanted, axes(link))), "by its name"
    parents = {joint.parent for joint in carried.values()}
    ends = [link for link in carried if link not in parents]
    best = max(ends, key=counts.__getitem__)
    return best, "as the end of the chain with most axes"


def exact_quarter_turn(angle: float, text: str) -> float:
    """An angle, a quarter turn's multiple if that printed as short as the text is the text."""
    digits = text.lstrip("+-").partition(".")[2]
    if len(digits) < LEAST_DECIMALS or not digits.isdigit():
        return angle
    exact = math.pi / 2.0 * round(angle / (math.pi / 2.0))
    shown = abs(exact) * 10.0 ** len(digits)
    given = round(abs(angle) * 10.0 ** len(digits))
    return exact if given in (math.floor(shown), round(shown)) else angle


def _is_called(link: str, wanted: str) -> bool:
    """Whether a link has a name, alone or behind a prefix."""
    return link == wanted or link.endswith(("_" + wanted, "-" + wanted, "/" + wanted))


def _path_to_root(link: str, carried: Mapping[str, UrdfJoint]) -> Iterator[UrdfJoint]:
    """The joints from a link to the root."""
    for _ in range(len(carried)):
        if link not in carried:
            return
        yield carried[link]
        link = carried[link].parent


def _parse_number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if abs(value) <= LARGEST else None

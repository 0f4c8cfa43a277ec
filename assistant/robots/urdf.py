"""Robots from URDF files: the chain of joints to the flange, and the shapes of the links.

Shapes are those of <collision>, or of <visual> if no link has a <collision>. A file that declares a
document type is refused, as its entities could grow without end or name other files. URDF states
metres and radians; an arm has mm, and angles in radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from pathlib import Path as FilePath
from typing import Any, Final, Literal
from xml.parsers import expat

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable, error, info
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.arms.arm import Arm
from assistant.robots.arms.arm import Joint as Axis
from assistant.robots.arms.serial import Serial
from assistant.robots.arms.spherical_wrist import recognise_six_axis
from assistant.robots.robot import Kind, Outline, Outlines, programming_languages

_NO_XML: Final = error(
    "RB004", "the robot file is no URDF: {reason}", "export it again, or write a robot file in TOML"
)
_DOCTYPE: Final = error(
    "RB005",
    "the robot file declares a document type, whose entities are not read",
    "take the `<!DOCTYPE …>` out",
)
_XACRO: Final = error(
    "RB006",
    "the robot file holds macros of xacro ({what})",
    "expand it first: `xacro arm.urdf.xacro > arm.urdf`",
)
_WRONG_ELEMENT: Final = error("RB007", "{element} {reason}", "correct the URDF, or export it again")
_MOST_NESTED: Final = 100
"""Elements inside each other; a URDF has four."""


@dataclass(slots=True)
class _XmlElement:
    tag: str
    attributes: dict[str, str]
    line: int
    column: int
    children: list[_XmlElement] = field(default_factory=list)

    def all(self, tag: str) -> list[_XmlElement]:
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> _XmlElement | None:
        return next(iter(self.all(tag)), None)

    def said(self) -> str:
        """The element as a message calls it."""
        name = self.attributes.get("name")
        return f"<{self.tag}>" if name is None else f"{self.tag} `{name}`"

    def wrong(self, path: str | None, reason: str, element: str | None = None) -> Diagnostic:
        return _WRONG_ELEMENT(
            path=path,
            line=self.line,
            column=self.column,
            element=element or self.said(),
            reason=reason,
        )


def _parse_xml(data: bytes, path: str | None) -> _XmlElement:
    """The root element; raises Unreadable."""
    parser = expat.ParserCreate()
    top = _XmlElement("", {}, 1, 1)
    open_ = [top]

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(open_) > _MOST_NESTED:
            raise Unreadable(_NO_XML(path=path, line=line(), reason="its elements are too deep"))
        column = parser.CurrentColumnNumber + 1
        element = _XmlElement(tag, attributes, line(), column)
        macro = next((v for v in (tag, *attributes.values()) if v.startswith("xacro:")), None)
        if macro is None:
            macro = next((v for v in attributes.values() if "${" in v or "$(" in v), None)
        if macro is not None:
            raise Unreadable(_XACRO(path=path, line=line(), column=column, what=macro))
        open_[-1].children.append(element)
        open_.append(element)

    def end(_: str) -> None:
        open_.pop()

    def line() -> int:
        return parser.CurrentLineNumber

    def doctype(*_: object) -> None:
        raise Unreadable(_DOCTYPE(path=path, line=line()))

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        column = error.offset + 1
        reason = expat.ErrorString(error.code)
        raise Unreadable(
            _NO_XML(path=path, line=error.lineno, column=column, reason=reason)
        ) from None
    except Unreadable:
        raise
    except (LookupError, ValueError) as error:  # of an encoding that expat or Python lacks
        raise Unreadable(_NO_XML(path=path, line=line(), reason=str(error))) from None
    root = top.children[0]
    if root.tag != "robot":
        raise Unreadable(_NO_XML(path=path, line=root.line, reason=f"its root is <{root.tag}>"))
    return root


_MOVING_JOINTS: Final = ("revolute", "continuous", "prismatic")
_JOINT_KINDS: Final = (*_MOVING_JOINTS, "fixed", "floating", "planar")
_FLANGE_NAMES: Final = ("tool0", "flange")
"""Names of links that are the flange, by convention of ROS-Industrial; the first that is there."""
_LARGEST: Final = 1e6
"""m, radians or these a second: the largest number that is accepted for a robot."""
_LEAST_DECIMALS: Final = 2
"""Decimals from which on an angle that is printed short of a quarter turn counts as one."""


@dataclass(frozen=True, slots=True)
class _UrdfJoint:
    """A joint of a URDF. xyz: m. rpy: radians. limits: radians or m, None if missing. velocity: a
    second.
    """

    name: str
    kind: str
    parent: str
    child: str
    element: _XmlElement
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    axis: tuple[float, float, float]
    limits: tuple[float, float] | None
    velocity: float | None
    rounded: bool
    follows: bool

    @property
    def moving(self) -> bool:
        return self.kind in _MOVING_JOINTS


@dataclass(slots=True)
class _UrdfReader:
    """Reads elements and collects what is wrong with them."""

    path: str | None
    findings: list[Diagnostic] = field(default_factory=list)

    def joint(self, element: _XmlElement) -> _UrdfJoint:
        name, kind = element.attributes.get("name", ""), element.attributes.get("type", "")
        if not name:
            self.wrong(element, "has no name")
        if kind not in _JOINT_KINDS:
            what = f"type `{kind}` is none of {', '.join(_JOINT_KINDS)}"
            self.wrong(
                element, f"has no type; there are {', '.join(_JOINT_KINDS)}" if not kind else what
            )
        ends = {}
        for end in ("parent", "child"):
            part = element.first(end)
            ends[end] = "" if part is None else part.attributes.get("link", "")
            if not ends[end]:
                self.wrong(element, f"names no {end} link")
        xyz, rpy, rounded = self.origin(element)
        axis = element.first("axis")
        return _UrdfJoint(
            name=name,
            kind=kind,
            parent=ends["parent"],
            child=ends["child"],
            element=element,
            xyz=xyz,
            rpy=rpy,
            axis=self.axis(element, axis) if kind in _MOVING_JOINTS else (0.0, 0.0, 1.0),
            limits=self.limits(element, kind),
            velocity=self.velocity(element) if kind in _MOVING_JOINTS else None,
            rounded=rounded,
            follows=element.first("mimic") is not None,
        )

    def origin(
        self, element: _XmlElement
    ) -> tuple[tuple[float, float, float], tuple[float, float, float], bool]:
        """Return its xyz in m and rpy in radians, and whether an angle was rounded to a quarter
        turn.
        """
        origin = element.first("origin")
        xyz = self.vector(element, origin, "xyz", (0.0, 0.0, 0.0))
        rpy = self.vector(element, origin, "rpy", (0.0, 0.0, 0.0))
        texts = (origin.attributes.get("rpy", "") if origin else "").split()
        exact = tuple(map(_exact_quarter_turn, rpy, texts)) if len(texts) == 3 else rpy
        return xyz, (exact[0], exact[1], exact[2]), exact != rpy

    def axis(self, joint: _XmlElement, axis: _XmlElement | None) -> tuple[float, float, float]:
        x, y, z = self.vector(joint, axis, "xyz", (1.0, 0.0, 0.0))
        length = math.hypot(x, y, z)
        if length < 1e-6:
            self.wrong(joint, "has an axis of length 0")
            return (0.0, 0.0, 1.0)
        return x / length, y / length, z / length

    def limits(self, joint: _XmlElement, kind: str) -> tuple[float, float] | None:
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

    def velocity(self, joint: _XmlElement) -> float | None:
        limit = joint.first("limit")
        value = None if limit is None else self.number(joint, limit, "velocity", None)
        return value if value is not None and value > 0.0 else None

    def vector(
        self,
        joint: _XmlElement,
        part: _XmlElement | None,
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
                f"has {key} `{text}` of <{part.tag}>, which is not three numbers up to "
                f"{_LARGEST:g}",
            )
            return usual
        return x, y, z

    def number(
        self, joint: _XmlElement, part: _XmlElement, key: str, usual: float | None
    ) -> float | None:
        text = part.attributes.get(key)
        value = usual if text is None else _parse_number(text)
        if text is not None and value is None:
            self.wrong(
                joint, f"has {key} `{text}` of <{part.tag}>, which is no number up to {_LARGEST:g}"
            )
        return value

    def wrong(self, element: _XmlElement, reason: str) -> None:
        self.findings.append(element.wrong(self.path, reason))

    def links(self, root: _XmlElement) -> dict[str, _XmlElement]:
        found: dict[str, _XmlElement] = {}
        for element in root.all("link"):
            name = element.attributes.get("name", "")
            if not name:
                self.wrong(element, "has no name")
            elif name in found:
                self.wrong(element, "stands there twice")
            found[name] = element
        return found

    def tree(self, root: _XmlElement) -> Mapping[str, _UrdfJoint]:
        """Name of a link → the joint that carries it."""
        links = self.links(root)
        joints = [self.joint(element) for element in root.all("joint")]
        carried: dict[str, _UrdfJoint] = {}
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
        self, root: _XmlElement, links: Mapping[str, _XmlElement], carried: Mapping[str, _UrdfJoint]
    ) -> None:
        roots = [name for name in links if name not in carried]
        if len(roots) != 1:
            what = f"has {len(roots)} links that no joint carries ({', '.join(roots[:5])}), not one"
            circle = "has no link that no joint carries: it is a circle"
            self.wrong(root, what if roots or not links else circle)
            return
        hanging = {roots[0]}
        for link, _ in _links_outwards(carried):
            hanging.add(link)
        for name in links:
            if name not in hanging:
                self.wrong(links[name], "hangs on itself")
                return


def _joint_chain(tip: str, carried: Mapping[str, _UrdfJoint]) -> tuple[_UrdfJoint, ...]:
    """The joints from the root to a link."""
    return tuple(reversed(list(_path_to_root(tip, carried))))


def _links_outwards(carried: Mapping[str, _UrdfJoint]) -> Iterator[tuple[str, _UrdfJoint]]:
    """The links that hang on a root, with the joints that carry them, each behind its parent."""
    children: dict[str, list[str]] = {}
    for link, joint in carried.items():
        children.setdefault(joint.parent, []).append(link)
    waiting = [link for root in children if root not in carried for link in children[root]]
    while waiting:
        link = waiting.pop()
        yield link, carried[link]
        waiting += children.get(link, ())


def _flange_link(carried: Mapping[str, _UrdfJoint]) -> tuple[str, str]:
    """The link that is the flange, and why: one of `_FLANGE_NAMES`, or the end with most axes."""
    counts: dict[str, tuple[int, int]] = {}
    for link, joint in _links_outwards(carried):
        moving, all_ = counts.get(joint.parent, (0, 0))
        counts[link] = moving + joint.moving, all_ + 1

    def axes(link: str) -> int:
        return counts[link][0]

    for wanted in _FLANGE_NAMES:
        named = [link for link in carried if _is_called(link, wanted) and axes(link)]
        if named:
            return max(named, key=lambda link: (link == wanted, axes(link))), "by its name"
    parents = {joint.parent for joint in carried.values()}
    ends = [link for link in carried if link not in parents]
    best = max(ends, key=counts.__getitem__)
    return best, "as the end of the chain with most axes"


def _exact_quarter_turn(angle: float, text: str) -> float:
    """An angle, a quarter turn's multiple if that printed as short as the text is the text."""
    digits = text.lstrip("+-").partition(".")[2]
    if len(digits) < _LEAST_DECIMALS or not digits.isdigit():
        return angle
    exact = math.pi / 2.0 * round(angle / (math.pi / 2.0))
    shown = abs(exact) * 10.0 ** len(digits)
    given = round(abs(angle) * 10.0 ** len(digits))
    return exact if given in (math.floor(shown), round(shown)) else angle


def _is_called(link: str, wanted: str) -> bool:
    """True if a link has a name, alone or after a prefix."""
    return link == wanted or link.endswith(("_" + wanted, "-" + wanted, "/" + wanted))


def _path_to_root(link: str, carried: Mapping[str, _UrdfJoint]) -> Iterator[_UrdfJoint]:
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
    return value if abs(value) <= _LARGEST else None


_METRE: Final = 1000.0
"""mm."""
_SHAPE_SIZES: Final[Mapping[Kind, tuple[str, ...]]] = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
}
"""Shape → its attributes in metres; `size` holds three. Those of the XML specification of URDF."""
_SHAPE_KINDS: Final = (*_SHAPE_SIZES, "mesh")


def _link_outlines(
    root: _XmlElement,
    carried: Mapping[str, _UrdfJoint],
    joints: Sequence[_UrdfJoint],
    arm: Arm,
    path: str | None,
) -> Outlines | None:
    """Return the outlines of the links of a tree whose joints lead to the flange of an arm; None if
    no link has any.

    carried: link → the joint that carries it.
    """
    links = {element.attributes.get("name", ""): element for element in root.all("link")}
    used: Literal["collision", "visual"] = "collision"
    if not any(_drawn_elements(element, used) for element in links.values()):
        used = "visual"
    if not any(_drawn_elements(element, used) for element in links.values()):
        return None
    reader = _UrdfReader(path)
    places = _placed(carried, joints)
    frames = dict(zip(_carriers(arm), _frames(arm), strict=True))
    shapes: list[Outline] = []
    for name, element in links.items():
        carrier, pose = places[name]
        there = frames[carrier].inverse() @ pose
        for part in _drawn_elements(element, used):
            shapes += _outline(reader, element, part, name, carrier, there)
    chain = {joint.name for joint in joints}
    hanging = {link for link, element in links.items() if _drawn_elements(element, used)}
    still = {j.name for link in hanging for j in _joint_chain(link, carried) if j.moving} - chain
    folder = str(FilePath(path or "robot.urdf").parent)
    return Outlines(tuple(shapes), folder, tuple(reader.findings), tuple(sorted(still)))


def _drawn_elements(link: _XmlElement, used: str) -> list[_XmlElement]:
    """The elements of a link that hold a geometry."""
    return [part for part in link.all(used) if part.first("geometry") is not None]


def _carriers(arm: Arm) -> tuple[str, ...]:
    return ("base", *arm.axes, "flange")


def _frames(arm: Arm) -> list[Pose]:
    """Return the frames of the carriers of bodies, with all joints at 0."""
    found = arm.whole_chain.along(np.zeros((1, len(arm.axes))))
    turns = rotations.from_matrix(found.frames[0])
    return [IDENTITY, *(Pose.of(p, q) for p, q in zip(found.origins[0], turns, strict=True))]


def _placed(
    carried: Mapping[str, _UrdfJoint], joints: Sequence[_UrdfJoint]
) -> dict[str, tuple[str, Pose]]:
    """Link → what carries it, and its pose in the base with all joints at 0."""
    root, tip = joints[0].parent, joints[-1].child
    axes = [joint.name for joint in joints if joint.moving]
    found: dict[str, tuple[str, Pose]] = {root: ("base", IDENTITY)}
    for link, joint in _links_outwards(carried):
        carrier, pose = found[joint.parent]
        if joint.name in axes:
            carrier = f"J{axes.index(joint.name) + 1}"
        if joint.parent == tip or (link == tip and not joint.moving):
            carrier = "flange"
        place = pose @ _origin_pose(joint.xyz, joint.rpy)
        if joint.moving and joint.name not in axes:
            place = place @ _rest_value(joint)
        found[link] = carrier, place
    return found


def _rest_value(joint: _UrdfJoint) -> Pose:
    """Return the pose of a joint that is not an axis of the arm: at 0, or at the limit nearest to
    0.
    """
    low, high = joint.limits or (0.0, 0.0)
    value = min(max(0.0, low), high)
    x, y, z = joint.axis
    if joint.kind == "prismatic":
        return Pose((x * value * _METRE, y * value * _METRE, z * value * _METRE))
    sine = math.sin(value / 2.0)
    return Pose(quaternion=(math.cos(value / 2.0), x * sine, y * sine, z * sine))


def _origin_pose(xyz: Vector, rpy: Vector) -> Pose:
    """Return the pose of metres and of radians about fixed axes."""
    roll, pitch, yaw = (math.degrees(angle) for angle in rpy)
    return Pose.of(np.array(xyz) * _METRE, rotations.from_euler([yaw, pitch, roll]))


def _outline(
    reader: _UrdfReader,
    link: _XmlElement,
    part: _XmlElement,
    name: str,
    carrier: str,
    there: Pose,
) -> Iterator[Outline]:
    """The shape of a <collision> or <visual>; what is wrong with it goes to the reader."""
    geometry = part.first("geometry")
    shapes = (
        [] if geometry is None else [one for one in geometry.children if one.tag in _SHAPE_KINDS]
    )
    if len(shapes) != 1:
        reader.wrong(
            link, f"has a <{part.tag}> whose <geometry> is not one of {', '.join(_SHAPE_KINDS)}"
        )
        return
    (shape,) = shapes
    before = len(reader.findings)
    xyz, rpy, _ = reader.origin(part)
    pose = there @ _origin_pose(xyz, rpy)
    if shape.tag == "mesh":
        file = shape.attributes.get("filename", "").strip()
        scale = reader.vector(link, shape, "scale", (1.0, 1.0, 1.0))
        if not file:
            reader.wrong(link, "has a <mesh> without a filename")
        elif not all(scale):
            reader.wrong(
                link, f"has a <mesh> of scale `{shape.attributes['scale']}`, which is flat"
            )
        if len(reader.findings) == before:
            yield Outline(name, carrier, pose, "mesh", file=file, scale=scale)
        return
    kind = next(kind for kind in _SHAPE_SIZES if kind == shape.tag)
    sizes: list[float] = []
    for key in _SHAPE_SIZES[kind]:
        if key == "size":
            sizes += reader.vector(link, shape, key, (0.0, 0.0, 0.0))
        else:
            sizes.append(reader.number(link, shape, key, 0.0) or 0.0)
    if len(reader.findings) == before and min(sizes) <= 0.0:
        said = ", ".join(f"{key} `{shape.attributes.get(key, '')}`" for key in _SHAPE_SIZES[kind])
        reader.wrong(link, f"has a <{kind}> of {said}: sizes are above 0")
    if len(reader.findings) == before:
        yield Outline(name, carrier, pose, kind, tuple(size * _METRE for size in sizes))


_ASSUMED: Final = info(
    "RB008",
    "a URDF does not say everything of a robot: {what}",
    "write a TOML file with the key `urdf` and what you know better",
)
_NOT_IN_NAMES: Final = re.compile(r"[^A-Za-z0-9_.-]+")
"""Characters that the name of a robot cannot hold, see `robot_file`."""
MOST_AXES: Final = 32
"""Largest number of axes of a chain; more than any arm has."""
_ENDLESS_TURN: Final = 360.0
"""degrees to either side for an axis that turns without end."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A robot in a URDF. arm: in closed form where possible. table: the remaining values, as in a
    robot file.

    missing: finding for each axis and field of the table that the file leaves out. findings:
    assumptions for values that the file does not state. outlines: of the links.
    """

    arm: Arm
    table: dict[str, Any]
    missing: dict[tuple[str, str], Diagnostic]
    findings: tuple[Diagnostic, ...]
    outlines: Outlines | None = None


def read(data: bytes, path: str | None) -> Drawn:
    """Raises Unreadable, or Refused with a finding for everything that is wrong."""
    root = _parse_xml(data, path)
    reader = _UrdfReader(path)
    carried = reader.tree(root)
    if reader.findings:
        raise Refused(*reader.findings)
    if not any(joint.moving for joint in carried.values()):
        raise Refused(root.wrong(path, "has no joint that moves"))
    tip, reason = _flange_link(carried)
    joints = _joint_chain(tip, carried)
    _refuse_unfit(joints, path)
    moving = [joint for joint in joints if joint.moving]
    if len(moving) > MOST_AXES:
        reason = f"has {len(moving)} axes up to link `{tip}`, more than {MOST_AXES}"
        raise Refused(root.wrong(path, reason))
    chain = _serial_arm(joints)
    arm = recognise_six_axis(chain) or chain
    table, missing = _robot_table(root, moving, arm, path)
    table["source"] = f"URDF, the chain from {joints[0].parent} to {tip}"
    notes = [f"the flange is link `{tip}`, {reason}"]
    if any(joint.rounded for joint in joints):
        notes.append("angles printed like 1.5708 are taken for quarter turns")
    if isinstance(arm, Serial):
        notes.append("its arm has no closed form here and is solved numerically")
    endless = [j.name for j in moving if j.kind == "continuous"]
    if endless:
        notes.append(
            f"{', '.join(endless)} turn without end and get {_ENDLESS_TURN:g} degrees either way"
        )
    what = "maker, languages, payload and home are assumed; " + "; ".join(notes)
    drawn = _link_outlines(root, carried, joints, arm, path)
    return Drawn(arm, table, missing, (_ASSUMED(path=path, what=what),), drawn)


def _refuse_unfit(joints: tuple[_UrdfJoint, ...], path: str | None) -> None:
    wrong = []
    for joint in joints:
        if joint.kind in ("floating", "planar"):
            wrong.append(joint.element.wrong(path, f"is {joint.kind}, which no axis of an arm is"))
        elif joint.moving and joint.follows:
            wrong.append(joint.element.wrong(path, "follows another joint, which is not supported"))
    if wrong:
        raise Refused(*wrong)


def _serial_arm(joints: tuple[_UrdfJoint, ...]) -> Serial:
    """Return the chain, with fixed joints merged into the moving joints after them."""
    axes, pose = [], IDENTITY
    for joint in joints:
        roll, pitch, yaw = (math.degrees(angle) for angle in joint.rpy)
        turn = rotations.from_euler([yaw, pitch, roll])
        pose = pose @ Pose.of(np.array(joint.xyz) * _METRE, turn)
        if joint.moving:
            sliding = joint.kind == "prismatic"
            unit = _METRE if sliding else 1.0
            low, high = joint.limits or (-math.pi, math.pi)
            axes.append(Axis(pose, joint.axis, sliding, low * unit, high * unit))
            pose = IDENTITY
    return Serial(tuple(axes), pose)


def _robot_table(
    root: _XmlElement, joints: list[_UrdfJoint], arm: Arm, path: str | None
) -> tuple[dict[str, Any], dict[tuple[str, str], Diagnostic]]:
    title = " ".join(root.attributes.get("name", "").split())
    name = _NOT_IN_NAMES.sub("-", title).strip("-_.")[:64] or "robot"
    table: dict[str, Any] = {
        "name": name,
        "title": title or name,
        "maker": "unknown",
        "controller": "unknown",
        "languages": list(programming_languages()),
        "configuration": "quadrants",
        "reach_mm": max(arm.reach, 1.0),
        "unconfirmed": ["maker", "controller", "languages", "configuration", "home"],
        "axes_deg": {},
        "axes_mm": {},
    }
    missing: dict[tuple[str, str], Diagnostic] = {}
    for axis, joint in zip(arm.axes, joints, strict=True):
        sliding = joint.kind == "prismatic"
        entry: dict[str, Any] = {}
        limits = (
            (-math.radians(_ENDLESS_TURN), math.radians(_ENDLESS_TURN))
            if joint.kind == "continuous"
            else None
        )
        limits = joint.limits or limits
        if limits is None:
            missing[axis, "limits"] = joint.element.wrong(path, "has no <limit> lower and upper")
        else:
            entry["limits"] = [_in_file_units(value, sliding) for value in limits]
            entry["home"] = min(max(0.0, entry["limits"][0]), entry["limits"][1])
        if joint.velocity is None:
            reason = "has no <limit> velocity above 0, so that nobody knows how fast it is"
            missing[axis, "speed"] = joint.element.wrong(path, reason)
        else:
            entry["speed"] = _in_file_units(joint.velocity, sliding)
        table["axes_mm" if sliding else "axes_deg"][axis] = entry
    return table, missing


def _in_file_units(value: float, sliding: bool) -> float:
    """Radians or m as degrees or mm."""
    return value * _METRE if sliding else math.degrees(value)

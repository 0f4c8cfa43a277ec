"""RAPID module of the pose exchange, printed from a template for each protocol.

Names are checked to be RAPID names, so that no text of a user becomes a statement. Whether tool,
work object, speed and zone are declared is left to the controller and to the checks of a program.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import cache
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers.abb.exchange import rules
from assistant.controllers.abb.files import TEXTS
from assistant.resources import resource

LANGUAGE: Final = "rapid"
_TEMPLATE: Final = "pose_exchange.mod"
_PLAIN_TEMPLATE: Final = "plain_exchange.mod"
_FILES: Final = ("request", "taken", "answer", "stop", "stopped")
_LONGEST_NAME: Final = 32
_LONGEST_FOLDER: Final = 40
"""A RAPID string has 80 characters at most, and the names of the files follow."""
_RESERVED: Final = re.compile(
    "alias|and|backward|case|connect|const|default|div|do|else|elseif|endfor|endfunc|endif|"
    "endmodule|endproc|endrecord|endtest|endtrap|endwhile|error|exit|false|for|from|func|goto|if|"
    "inout|local|mod|module|nostepin|not|noview|or|pers|proc|raise|readonly|record|retry|return|"
    "step|sysmodule|task|test|then|to|trap|true|trynext|undo|var|viewonly|while|with|xor"
)
"""Reserved words of RAPID (technical reference manual, RAPID kernel)."""
_LEAST_POLL, _LEAST_LOOK = 0.04, 0.1
"""Seconds: WaitUntil looks as often as that, ITimer comes as often as that (RAPID instructions)."""


@dataclass(frozen=True, slots=True)
class Tool:
    """Data of a tool that the module declares itself.

    position: mm, quaternion: (w, x, y, z), of its tip on the flange. mass: kg. centre: mm.
    """

    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    mass: float = 1.0
    centre: tuple[float, float, float] = (0.0, 0.0, 50.0)


@dataclass(frozen=True, slots=True)
class PlainFiles:
    """Names of the files of the plain protocol, each time of position, orientation, configuration.

    sent: from the PC; the first is put there last, as some programs wait only for it. answers: from
    the robot.
    """

    sent: tuple[str, str, str] = ("position.txt", "orientation.txt", "configuration.txt")
    answers: tuple[str, str, str] = (
        "selfposition.txt",
        "selforientation.txt",
        "selfconfiguration.txt",
    )

    def __post_init__(self) -> None:
        """Raise Refused unless there are three and three names that are safe on every disk."""
        names = (*self.sent, *self.answers)
        wrong = {name: _no_file(name, names) for name in names}
        if not len(self.sent) == len(self.answers) == 3:
            wrong = {", ".join(names): "three names are needed for each direction"}
        for name, reason in wrong.items():
            if reason:
                wanted = "six different names such as `position.txt`"
                finding = rules.BAD_NAME(
                    given=name, what="name of a file", reason=reason, wanted=wanted
                )
                raise Refused(finding)


def _no_file(name: str, names: Sequence[str]) -> str:
    """Why a name cannot be that of a file of the plain protocol; empty if it can."""
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*(\.[A-Za-z0-9]+)?", name) is None:
        return "it must be safe on every disk"
    if len(name) > _LONGEST_NAME:
        return f"it has more than {_LONGEST_NAME} characters"
    if name.lower().removesuffix(".txt").endswith(("_claim", "_claimant")):
        return "what keeps other computers away has such a name"
    if name.lower().endswith((*TEXTS, ".new")):
        return "files with this suffix are programs or are not complete yet"
    if [other.lower() for other in names].count(name.lower()) > 1:
        return "two files have it"
    return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Module:
    """Contents of the exchange module.

    tool, work_object, speed, zone: names on the controller. tool_data: declares the tool in the
    module. folder, prefix: of the files on the controller. longest: seconds without a request after
    which the program ends. poll: seconds between polls for a request. look: seconds between polls
    for a stop. plain: names of the files of the plain protocol, for a module that uses it; it stops
    at each pose, and has no zone.
    """

    module: str = "PoseExchange"
    tool: str = "tool0"
    work_object: str = "wobj0"
    speed: str = "v150"
    zone: str = "z100"
    tool_data: Tool | None = None
    folder: str = "HOME:"
    prefix: str = "exchange"
    longest: float = 240.0
    poll: float = _LEAST_POLL
    look: float = 0.2
    plain: PlainFiles | None = None

    def text(self) -> str:
        """The module; raises Refused with all that is wrong."""
        findings = [*self._wrong_names(), *self._wrong_numbers()]
        if findings:
            raise Refused(*findings)
        from jinja2 import Environment, StrictUndefined

        environment = Environment(  # noqa: S701 - RAPID, whose names were checked
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
        )
        folder = self.folder.rstrip("/")
        files = {file: f"{folder}/{name}" for file, name in file_names(self.prefix).items()}
        return environment.from_string(_text_of(self._template)).render(
            folder=folder,
            plain=self.plain,
            module=self.module,
            tool=self.tool,
            work_object=self.work_object,
            # wobj0 is the default of every move: leaving it out reads as people write it.
            wobj="" if self.work_object == "wobj0" else f"\\WObj:={self.work_object}",
            speed=self.speed,
            zone=self.zone,
            tool_data=_tool_data(self.tool_data),
            longest=_number(self.longest),
            poll=_number(self.poll),
            look=_number(self.look),
            **files,
        )

    @property
    def _template(self) -> str:
        return _TEMPLATE if self.plain is None else _PLAIN_TEMPLATE

    def _wrong_names(self) -> list[Diagnostic]:
        found = []
        for what in ("module", "tool", "work_object", "speed", "zone"):
            given = getattr(self, what)
            reason = _no_name(given, self._template)
            if reason:
                found.append(
                    rules.BAD_NAME(
                        given=given,
                        what=what.replace("_", " "),
                        reason=reason,
                        wanted="a letter, then letters, digits and `_`",
                    )
                )
        if re.fullmatch(r"[A-Za-z0-9]+:(/[A-Za-z0-9_-]+)*/?", str(self.folder)) is None or (
            len(self.folder) > _LONGEST_FOLDER
        ):
            found.append(
                rules.BAD_NAME(
                    given=self.folder,
                    what="folder",
                    reason=f"it is no folder of a unit in {_LONGEST_FOLDER} characters",
                    wanted="`HOME:` or `HOME:/folder`",
                )
            )
        return found

    def _wrong_numbers(self) -> list[Diagnostic]:
        checks = (
            ("longest wait", self.longest, 1.0),
            ("time between looks for a request", self.poll, _LEAST_POLL),
            ("time between looks for a stop", self.look, _LEAST_LOOK),
        )
        found = [
            rules.BAD_NUMBER(given=given, what=what, wanted=f"{least:g} to 100000 seconds")
            for what, given, least in checks
            if not isinstance(given, float | int) or not least <= given <= 100_000.0
        ]
        tool = self.tool_data
        if tool is not None:
            values = (*tool.position, *tool.quaternion, tool.mass, *tool.centre)
            if not all(map(math.isfinite, values)) or tool.mass < 0.001:
                found.append(
                    rules.BAD_NUMBER(
                        given=tool.mass,
                        what="mass of a tool with finite figures",
                        wanted="0.001 kg or more, for a robot without load data stops",
                    )
                )
        return found


def file_names(prefix: str) -> dict[str, str]:
    """Names of the files by what they are, `_FILES`; raises Refused for a prefix that is unsafe."""
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,19}", str(prefix)) is None:
        raise Refused(
            rules.BAD_NAME(
                given=prefix,
                what="beginning of the file names",
                reason="it must be safe on every disk",
                wanted="a letter, then at most 19 letters, digits and `_`",
            )
        )
    return {file: f"{prefix}_{file}.txt" for file in _FILES}


def _no_name(given: str, template: str) -> str:
    """Why a text is not a RAPID name that the module can use; empty if it is."""
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", str(given)) is None:
        return "it is no name of ASCII letters, digits and `_`"
    if len(given) > _LONGEST_NAME:
        return f"it has more than {_LONGEST_NAME} characters"
    if _RESERVED.fullmatch(given.lower()):
        return "the word is reserved"
    # `fine` is a word of the template, but the name of a zone as well.
    if given.lower() != "fine" and given.lower() in _own_words(template):
        return "the module uses the word itself"
    return ""


def _text_of(template: str) -> str:
    return resource("templates", template).read_text(encoding="utf-8")


@cache
def _own_words(template: str) -> frozenset[str]:
    """Words of a template in lower case, names that it declares and calls among them."""
    # Comments and template statements declare nothing.
    text = re.sub(r"\{[{%].*?[%}]\}|!.*", "", _text_of(template))
    return frozenset(word.lower() for word in re.findall(r"[A-Za-z]\w*", text))


def _tool_data(tool: Tool | None) -> str:
    if tool is None:
        return ""
    place, turn, centre = map(_row, (tool.position, tool.quaternion, tool.centre))
    return f"[TRUE,[{place},{turn}],[{_number(tool.mass)},{centre},[1,0,0,0],0,0,0]]"


def _row(values: Sequence[float]) -> str:
    return "[" + ",".join(map(_number, values)) + "]"


def _number(value: float) -> str:
    return f"{value + 0.0:.9g}"

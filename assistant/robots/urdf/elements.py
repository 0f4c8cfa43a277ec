"""XML elements with their lines. A file that declares a document type is refused: its entities
could grow without end or name other files.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

from assistant.base.diagnostics import Diagnostic, Unreadable, error

NO_XML: Final = error(
    "RB004", "the robot file is no URDF: {reason}", "export it again, or write a robot file in TOML"
)
DOCTYPE: Final = error(
    "RB005",
    "the robot file declares a document type, whose entities are not read",
    "take the `<!DOCTYPE …>` out",
)
XACRO: Final = error(
    "RB006",
    "the robot file holds macros of xacro ({what})",
    "expand it first: `xacro arm.urdf.xacro > arm.urdf`",
)
WRONG_ELEMENT: Final = error("RB007", "{element} {reason}", "correct the URDF, or export it again")
MOST_NESTED: Final = 100
"""Elements inside each other; a URDF has four."""


@dataclass(slots=True)
class XmlElement:
    tag: str
    attributes: dict[str, str]
    line: int
    column: int
    children: list[XmlElement] = field(default_factory=list)

    def all(self, tag: str) -> list[XmlElement]:
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> XmlElement | None:
        return next(iter(self.all(tag)), None)

    def said(self) -> str:
        """The element as a message calls it."""
        name = self.attributes.get("name")
        return f"<{self.tag}>" if name is None else f"{self.tag} `{name}`"

    def wrong(self, path: str | None, reason: str, element: str | None = None) -> Diagnostic:
        return WRONG_ELEMENT(
            path=path,
            line=self.line,
            column=self.column,
            element=element or self.said(),
            reason=reason,
        )


def parse_xml(data: bytes, path: str | None) -> XmlElement:
    """The root element; raises Unreadable."""
    parser = expat.ParserCreate()
    top = XmlElement("", {}, 1, 1)
    open_ = [top]

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(open_) > MOST_NESTED:
            raise Unreadable(NO_XML(path=path, line=line(), reason="its elements are too deep"))
        column = parser.CurrentColumnNumber + 1
        element = XmlElement(tag, attributes, line(), column)
        macro = next((v for v in (tag, *attributes.values()) if v.startswith("xacro:")), None)
        if macro is None:
            macro = next((v for v in attributes.values() if "${" in v or "$(" in v), None)
        if macro is not None:
            raise Unreadable(XACRO(path=path, line=line(), column=column, what=macro))
        open_[-1].children.append(element)
        open_.append(element)

    def end(_: str) -> None:
        open_.pop()

    def line() -> int:
        return parser.CurrentLineNumber

    def doctype(*_: object) -> None:
        raise Unreadable(DOCTYPE(path=path, line=line()))

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        column = error.offset + 1
        reason = expat.ErrorString(error.code)
        raise Unreadable(
            NO_XML(path=path, line=error.lineno, column=column, reason=reason)
        ) from None
    except Unreadable:
        raise
    except (LookupError, ValueError) as error:  # of an encoding that expat or Python lacks
        raise Unreadable(NO_XML(path=path, line=line(), reason=str(error))) from None
    root = top.children[0]
    if root.tag != "robot":
        raise Unreadable(NO_XML(path=path, line=root.line, reason=f"its root is <{root.tag}>"))
    return root

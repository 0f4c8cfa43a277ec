"""How each statement of the pseudo-program is written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from assistant.languages.melfa_basic.convert.words import reworded
from assistant.languages.melfa_basic.lower import (
    channels,
    control,
    interrupts,
    motions,
    signals,
)
from assistant.languages.melfa_basic.lower.expressions import Unsayable
from assistant.languages.melfa_basic.lower.writer import Writer, marked
from assistant.languages.melfa_basic.reading.parser import statement as read_statement
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tables.statements import ROWS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import statements as p


def comment(w: Writer, node: p.Comment) -> None:
    w.items.append(s.Line(comment=marked(node)))


def message(_: Writer, node: p.Message) -> None:
    raise Unsayable(f"the message of {len(node.parts)} parts on the teach pendant", "leave it out")


def opaque(w: Writer, node: p.Opaque) -> None:
    line = opaque_line(node, w.dialect)
    if line is None or line.statement is None:
        what, cure = f"the {node.language} statement `{node.text}`", "say it in plain statements"
        if node.reason is not None:
            what, cure = f"{what}: {node.reason.why}", node.reason.cure
        raise Unsayable(what, cure)
    w.items.append(line)
    w.forget()


def opaque_line(node: p.Opaque, dialect: Dialect) -> s.Line | None:
    """The line of a vendor statement that this dialect accepts, or has other words for."""
    origin = DIALECTS.get(node.language)
    line = None if origin is None else read_statement(node.text)
    if origin is None or line is None or line.label is not None or line.comment is not None:
        return None
    return line if origin.level <= dialect.level else reworded(line, dialect)


STATEMENTS: Final[dict[type, Callable[[Writer, Any], None]]] = {
    **dict.fromkeys(ROWS.records, signals.plain),
    p.Move: motions.move,
    p.MoveCircular: motions.move_circular,
    p.MoveJoints: motions.move_joints,
    p.Follow: motions.follow,
    p.WaitSignal: signals.wait_signal,
    p.WaitUntil: signals.wait_until,
    p.StartTimer: signals.start_timer,
    p.SetSignal: signals.set_signal,
    p.Call: control.call,
    p.Assign: control.assign,
    p.If: control.if_,
    p.While: control.while_,
    p.For: control.for_,
    p.Switch: control.switch,
    p.Stop: control.stop,
    p.Return: control.return_,
    p.Comment: comment,
    p.Label: control.label,
    p.Goto: control.goto,
    p.Message: message,
    p.Attach: channels.attach,
    p.Detach: channels.detach,
    p.Send: channels.send,
    **interrupts.STATEMENTS,
    p.Opaque: opaque,
}

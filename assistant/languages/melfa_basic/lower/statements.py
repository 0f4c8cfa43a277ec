"""How each statement of the pseudo-program is written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from assistant.languages.melfa_basic.convert.words import reworded
from assistant.languages.melfa_basic.lower import channels, control, interrupts, motions, signals
from assistant.languages.melfa_basic.lower.expressions import Unsayable
from assistant.languages.melfa_basic.lower.writer import Writer, marked
from assistant.languages.melfa_basic.reading.parser import statement as read_statement
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tables.statements import STATEMENT_ROWS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import statements as p


def write_comment(w: Writer, node: p.Comment) -> None:
    w.items.append(s.Line(comment=marked(node)))


def write_message(_: Writer, node: p.Message) -> None:
    raise Unsayable(f"the message of {len(node.parts)} parts on the teach pendant", "leave it out")


def write_vendor_statement(w: Writer, node: p.Opaque) -> None:
    line = vendor_line(node, w.dialect)
    if line is None or line.statement is None:
        what, cure = f"the {node.language} statement `{node.text}`", "say it in plain statements"
        if node.reason is not None:
            what, cure = f"{what}: {node.reason.why}", node.reason.cure
        raise Unsayable(what, cure)
    w.items.append(line)
    w.forget()


def vendor_line(node: p.Opaque, dialect: Dialect) -> s.Line | None:
    """The line of a vendor statement that this dialect accepts, or has other words for."""
    origin = DIALECTS.get(node.language)
    line = None if origin is None else read_statement(node.text)
    if origin is None or line is None or line.label is not None or line.comment is not None:
        return None
    return line if origin.level <= dialect.level else reworded(line, dialect)


STATEMENTS: Final[dict[type, Callable[[Writer, Any], None]]] = {
    **dict.fromkeys(STATEMENT_ROWS.records, signals.write_row),
    p.Move: motions.write_move,
    p.MoveCircular: motions.write_circular_move,
    p.MoveJoints: motions.write_joint_move,
    p.Follow: motions.write_path,
    p.WaitSignal: signals.write_signal_wait,
    p.WaitUntil: signals.write_wait,
    p.StartTimer: signals.write_timer_start,
    p.SetSignal: signals.write_signal,
    p.Call: control.write_call,
    p.Assign: control.write_assignment,
    p.If: control.write_if,
    p.While: control.write_while,
    p.For: control.write_for,
    p.Switch: control.write_switch,
    p.Stop: control.write_stop,
    p.Return: control.write_return,
    p.Comment: write_comment,
    p.Label: control.write_label,
    p.Goto: control.write_goto,
    p.Message: write_message,
    p.Attach: channels.write_open,
    p.Detach: channels.write_close,
    p.Send: channels.write_print,
    **interrupts.INTERRUPT_WRITERS,
    p.Opaque: write_vendor_statement,
}

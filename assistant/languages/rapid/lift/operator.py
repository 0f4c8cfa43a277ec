r"""What a program of RAPID tells and asks a person, as other languages are told it.

Texts on the teach pendant and in the event log are messages. Questions become waits for inputs
(`asking`): the keys of TPReadFK and of the boxes are counted from the left, a number stands at a
group of inputs. Reference manual of instructions: TPReadFK, TPReadNum, UIMsgBox, ErrWrite; of
functions: UINumEntry, UIMessageBox.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

from assistant.languages.patterns import Called
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.instructions import Meaning
from assistant.languages.rapid.tables.words import ANSWERS
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called, name_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Findings
from assistant.program.passes import asking
from assistant.program.program import Program
from assistant.program.rewriting import Body, map_bodies

NONE: Final = "stempty"
"""Predefined: the text of a key that is not there."""
BUTTONS: Final[Mapping[str, Sequence[str]]] = {
    "btnnone": (),
    "btnok": ("resOK",),
    "btnabrtrtryign": ("resAbort", "resRetry", "resIgnore"),
    "btnokcancel": ("resOK", "resCancel"),
    "btnretrycancel": ("resRetry", "resCancel"),
    "btnyesno": ("resYes", "resNo"),
    "btnyesnocancel": ("resYes", "resNo", "resCancel"),
}
"""What the buttons of a box stand for, by the name of their `buttondata`."""
LOOKS: Final = frozenset(("wrap", "icon", "image", "uiactivesignal"))
"""Options of a box that only show."""
LINES: Final = ("header", "message", "msgline2", "msgline3", "msgline4", "msgline5")
DIALOGS: Final = frozenset(("uinumentry", "uidnumentry", "uimessagebox"))
"""Functions that ask."""

STOPPED: Final[Mapping[str, str]] = {
    "stop": "none is needed where nobody moves the robot while it stands",
    "break": "none is needed once the program is tried out",
}
"""What to do about stops that are plain ones elsewhere: without options, behind the move before."""
ENDED: Final = e.Reason(
    "the question ends by itself, and the program goes on with an error or without an answer",
    "ask without a time and a break, or wait for inputs in the program",
)
WORKED_OUT: Final = e.Reason(
    "which keys it has is only known as it runs",
    "write the texts of the keys out, and `stEmpty` for those that are not there",
)
Said: TypeAlias = Iterator[p.Statement]


@dataclass(frozen=True, slots=True)
class _Question:
    """call: the instruction or function that asks. answer: of a function, where its result goes."""

    call: Called[s.Expression]
    value: Callable[[s.Expression], e.Expression]
    answer: e.Expression | None = None

    def given(self, at: int) -> e.Expression | None:
        node = self.call.given[at] if at < len(self.call.given) else None
        return None if node is None else self.value(node)

    def option(self, name: str) -> e.Expression | None:
        node = self.call.options.get(name)
        return None if node is None else self.value(node)

    def only(self, *names: str) -> bool:
        """Whether it has no options but these, and those that only show."""
        return set(self.call.options) <= {*names, *LOOKS}


class _Unsaid(Exception):
    """A question that inputs do not answer."""

    def __init__(self, reason: e.Reason | None = None) -> None:
        super().__init__()
        self.reason = reason


def with_operator(program: Program, findings: Findings) -> Program:
    """The program with messages and waits for inputs where RAPID talks to a person."""

    def body(statements: Body) -> Body:
        return tuple(part for node in statements for part in said(node))

    def said(node: p.Statement) -> Said:
        question = _question(node)
        if question is None:
            yield map_bodies(node, body)
            return
        word = question.call.word.lower()
        try:
            made = tuple(_ASKED[word](question))
        except _Unsaid as unsaid:
            if isinstance(node, p.Opaque) and unsaid.reason is not None:
                node = replace(node, reason=unsaid.reason)
            yield node
            return
        with findings.at(node.span):
            if word in STOPPED and isinstance(node, p.Opaque):
                text, cure = node.text.rstrip(";"), STOPPED[word]
                findings.append(rules.CHANGED(what=f"`{text}`", instead="a plain stop", cure=cure))
            elif any(isinstance(one, p.WaitUntil) for one in made):
                findings.append(rules.ASKED(what=question.call.word))
        yield from (replace(one, span=node.span) for one in made)

    told = replace(
        program, procedures=tuple(replace(q, body=body(q.body)) for q in program.procedures)
    )
    return asking.with_answers(told)


def _question(node: p.Statement) -> _Question | None:
    match node:
        case p.Opaque(verbatim.LANGUAGE, text):
            match verbatim.understood(verbatim.statements, text):
                case (s.ProcedureCall(name=str(word)) as call,) if word.lower() in _ASKED:
                    found = called(call)
                    return None if found is None else _Question(found, Meaning().expression)
        case p.Assign(target, e.Verbatim(verbatim.LANGUAGE, text)) if _asks(text):
            match verbatim.understood(verbatim.expression, text):
                case s.FunctionCall(str(word)) as function if word.lower() in DIALOGS:
                    found = called(function)
                    expression = Meaning().expression
                    return None if found is None else _Question(found, expression, target)
    return None


def _asks(text: str) -> bool:
    """Whether a text may be a call of a dialog, which is cheaper to see than to read."""
    return text.partition("(")[0].strip().lower() in DIALOGS


# ----------------------------------------------------------------------------- what is said


def _stop(q: _Question) -> Said:
    """Stop with its options, and Break."""
    if q.call.given or not set(q.call.options) <= {"noregain", "allmovetasks"}:
        raise _Unsaid
    yield p.Stop()


def _report(q: _Question) -> Said:
    """ErrWrite: a header, and lines."""
    lines = [q.given(0), q.given(1), *(q.option(f"rl{n}") for n in (2, 3, 4))]
    yield p.Message(_joined(one for one in lines if one is not None))


def _log(q: _Question) -> Said:
    """ErrLog: a number, and texts that stand in the message of that number."""
    lines = [q.value(node) for node in q.call.given if node is not None]
    yield p.Message(_joined(lines))


def _joined(lines: Iterator[e.Expression] | Sequence[e.Expression]) -> tuple[e.Expression, ...]:
    found: list[e.Expression] = []
    for line in lines:
        found += [e.Text("; "), line] if found else [line]
    return tuple(found)


def _keys(q: _Question) -> Said:
    """TPReadFK: the number of the key that is pressed, of five."""
    if not q.only():
        raise _Unsaid(ENDED)
    answer, question = q.given(0), q.given(1)
    nodes = q.call.given[2:7]
    shown = [(n, node) for n, node in enumerate(nodes, 1) if name_of(node).lower() != NONE]
    shown = [(n, node) for n, node in shown if node != s.StringLiteral("")]
    if answer is None or question is None or not shown:
        raise _Unsaid
    if any(not isinstance(node, s.StringLiteral) for _, node in shown):
        raise _Unsaid(WORKED_OUT)
    texts = [f" [{n}: {node.value}]" for n, node in shown if isinstance(node, s.StringLiteral)]
    yield p.Message((question, e.Text("".join(texts))))
    keys = [n for n, _ in shown]
    yield from asking.asked_for_key(answer, keys, [e.Number(n) for n in keys])


def _number(q: _Question) -> Said:
    """TPReadNum."""
    answer, question = q.given(0), q.given(1)
    if not q.only():
        raise _Unsaid(ENDED)
    if answer is None or question is None:
        raise _Unsaid
    yield p.Message((question,))
    yield from asking.asked_for_number(answer)


def _entry(q: _Question) -> Said:
    """UINumEntry: a number between two. What it begins with is only shown."""
    if not q.only("header", "message", "initvalue", "minvalue", "maxvalue", "asinteger"):
        raise _Unsaid(ENDED)
    assert q.answer is not None
    yield p.Message(_shown(q))
    least, most = q.option("minvalue"), q.option("maxvalue")
    yield from asking.asked_for_number(q.answer, least, most)


def _box(q: _Question) -> Said:
    """UIMsgBox and UIMessageBox: what the button that is pressed stands for."""
    if not q.only("header", "message", "buttons", "btnarray", "result", "defaultbtn", *LINES[2:]):
        raise _Unsaid(ENDED)
    answer = q.option("result") if q.answer is None else q.answer
    buttons = _buttons(q)
    keys = range(1, len(buttons) + 1)
    texts = [f" [{n}: {name}]" for n, (name, _) in zip(keys, buttons, strict=True)]
    yield p.Message((*_shown(q), e.Text("".join(texts))))
    if not buttons and answer is not None:
        raise _Unsaid
    if buttons:
        yield from asking.asked_for_key(answer, keys, [e.Number(value) for _, value in buttons])


def _buttons(q: _Question) -> list[tuple[str, int]]:
    """The names of the buttons of a box, and what each gives."""
    node, own = q.call.options.get("buttons"), q.call.options.get("btnarray")
    if isinstance(own, s.AggregateNode):
        names = [one.value for one in own.items if isinstance(one, s.StringLiteral)]
        if len(names) == len(own.items):
            return [(name, place) for place, name in enumerate(names, 1)]
    known = BUTTONS.get("btnok" if node is None else name_of(node).lower())
    if own is not None or known is None:
        raise _Unsaid(WORKED_OUT)
    return [(one.removeprefix("res"), ANSWERS[one.lower()]) for one in known]


def _shown(q: _Question) -> tuple[e.Expression, ...]:
    first = [q.given(0)] if q.answer is None else []
    lines = [q.option("header"), *first, *(q.option(name) for name in LINES[1:])]
    return _joined([line for line in lines if line is not None])


_ASKED: Final[Mapping[str, Callable[[_Question], Said]]] = {
    "break": _stop,
    "stop": _stop,
    "errwrite": _report,
    "errlog": _log,
    "tpreadfk": _keys,
    "tpreadnum": _number,
    "tpreaddnum": _number,
    "uimsgbox": _box,
    "uimessagebox": _box,
    "uinumentry": _entry,
    "uidnumentry": _entry,
}
"""By lower-case names of instructions and functions."""

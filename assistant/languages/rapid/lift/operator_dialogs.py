"""Messages and questions to the operator, for other languages.

Texts on the teach pendant and in the event log become messages. Questions become waits for inputs
(`asking`): the keys of TPReadFK and of message boxes are counted from the left, a number is read
from a group of inputs. Reference manual of instructions: TPReadFK, TPReadNum, UIMsgBox, ErrWrite;
of functions: UINumEntry, UIMessageBox.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.vendor_statements import (
    NotExpressible,
    Replacement,
    VendorCall,
    with_lowered_calls,
)
from assistant.languages.rapid.tables.constants import BUTTON_ANSWERS
from assistant.languages.rapid.text.printer import expression as printed
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import name_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes import operator_texts
from assistant.program.program import Program

_EMPTY_TEXT: Final = "stempty"
"""Predefined: the text of a key that is not there."""
_BUTTONS: Final[Mapping[str, Sequence[str]]] = {
    "btnnone": (),
    "btnok": ("resOK",),
    "btnabrtrtryign": ("resAbort", "resRetry", "resIgnore"),
    "btnokcancel": ("resOK", "resCancel"),
    "btnretrycancel": ("resRetry", "resCancel"),
    "btnyesno": ("resYes", "resNo"),
    "btnyesnocancel": ("resYes", "resNo", "resCancel"),
}
"""Results of the buttons of a dialog box, by the name of its `buttondata`."""
_DISPLAY_OPTIONS: Final = frozenset(("wrap", "icon", "image", "uiactivesignal"))
"""Options of a box that only show."""
LINES: Final = ("header", "message", "msgline2", "msgline3", "msgline4", "msgline5")
_DIALOGS: Final = frozenset(("uinumentry", "uidnumentry", "uimessagebox"))
"""Functions that ask."""

_STOPPED: Final[Mapping[str, str]] = {
    "stop": "none is needed where nobody moves the robot while it stands",
    "break": "none is needed once the program is tried out",
}
"""Cures for stops that become plain stops in other languages: without options, after the previous
move.
"""
ENDED: Final = e.Reason(
    "the question ends by itself, and the program goes on with an error or without an answer",
    "ask without a time and a break, or wait for inputs in the program",
)
_COMPUTED_TEXT: Final = e.Reason(
    "which keys it has is only known as it runs",
    "write the texts of the keys out, and `stEmpty` for those that are not there",
)


def with_operator_dialogs(program: Program, findings: Findings) -> Program:
    """The program with messages and waits for inputs where RAPID talks to a person."""

    def said(call: VendorCall, node: p.Statement) -> Replacement:
        word = call.word
        made = tuple(_LOWERINGS[word](call))
        with findings.at(node.span):
            if word in _STOPPED and isinstance(node, p.Opaque):
                text, cure = node.text.rstrip(";"), _STOPPED[word]
                findings.append(rules.CHANGED(what=f"`{text}`", instead="a plain stop", cure=cure))
            elif any(isinstance(one, p.WaitUntil) for one in made):
                findings.append(rules.ASKED(what=call.call.word))
        yield from made

    told = with_lowered_calls(program, _LOWERINGS, _DIALOGS, said)
    return operator_texts.with_answers(told)


# ----------------------------------------------------------------------------- what is said


def _stop_statement(q: VendorCall) -> Replacement:
    """Stop with its options, and Break."""
    # Other options of Stop or Break are not known to have the effect of a plain stop.
    if q.call.given or not set(q.call.options) <= {"noregain", "allmovetasks"}:
        raise NotExpressible
    yield p.Stop()


def _error_message(q: VendorCall) -> Replacement:
    """ErrWrite: a header, and lines."""
    lines = [q.given(0), q.given(1), *(q.option(f"rl{n}") for n in (2, 3, 4))]
    yield p.Message(_joined_lines(one for one in lines if one is not None))


def _event_message(q: VendorCall) -> Replacement:
    """Lower ErrLog: a number, and the texts in the message of that number."""
    lines = [q.value(node) for node in q.call.given if node is not None]
    yield p.Message(_joined_lines(lines))


def _joined_lines(
    lines: Iterator[e.Expression] | Sequence[e.Expression],
) -> tuple[e.Expression, ...]:
    found: list[e.Expression] = []
    for line in lines:
        found += [e.Text("; "), line] if found else [line]
    return tuple(found)


def _key_question(q: VendorCall) -> Replacement:
    """TPReadFK: the number of the key that is pressed, of five."""
    if not q.only(*_DISPLAY_OPTIONS):
        # Any other option ends the question by itself.
        raise NotExpressible(ENDED)
    answer, question = q.given(0), q.given(1)
    nodes = q.call.given[2:7]
    # A key without a text is not shown, but the keys keep their numbers.
    shown = [(n, node) for n, node in enumerate(nodes, 1) if name_of(node).lower() != _EMPTY_TEXT]
    shown = [(n, node) for n, node in shown if node != s.StringLiteral("")]
    if answer is None or question is None or not shown:
        raise NotExpressible
    texts = [f" [{n}: {_button_text(node)}]" for n, node in shown if node is not None]
    yield p.Message((question, e.Text("".join(texts))))
    keys = [n for n, _ in shown]
    counts = [_key_has_text(q, node) for _, node in shown if node is not None]
    yield from operator_texts.asked_for_key(answer, keys, [e.Number(n) for n in keys], counts)


def _key_has_text(q: VendorCall, node: s.Expression) -> e.Expression | None:
    """The condition under which a key has a text, None if it always has one."""
    if isinstance(node, s.StringLiteral):
        return None
    if not isinstance(node, s.NameRef | s.Component | s.Element):
        raise NotExpressible(_COMPUTED_TEXT)
    return e.Binary("<>", q.value(node), e.Text(""))


def _number_question(q: VendorCall) -> Replacement:
    """TPReadNum."""
    answer, question = q.given(0), q.given(1)
    if not q.only(*_DISPLAY_OPTIONS):
        raise NotExpressible(ENDED)
    if answer is None or question is None:
        raise NotExpressible
    yield p.Message((question,))
    yield from operator_texts.asked_for_number(answer)


def _number_entry(q: VendorCall) -> Replacement:
    """UINumEntry: a number between two. What it begins with is only shown."""
    if not q.only(
        "initvalue", "minvalue", "maxvalue", "asinteger", "msgarray", *LINES, *_DISPLAY_OPTIONS
    ):
        raise NotExpressible(ENDED)
    assert q.answer is not None
    yield p.Message(_shown_texts(q))
    least, most = q.option("minvalue"), q.option("maxvalue")
    yield from operator_texts.asked_for_number(q.answer, least, most)


def _message_box(q: VendorCall) -> Replacement:
    """UIMsgBox and UIMessageBox: what the button that is pressed stands for."""
    if not q.only(
        "header",
        "message",
        "msgarray",
        "buttons",
        "btnarray",
        "result",
        "defaultbtn",
        *LINES[2:],
        *_DISPLAY_OPTIONS,
    ):
        raise NotExpressible(ENDED)
    answer = q.option("result") if q.answer is None else q.answer
    listed = _option_elements(q, "btnarray")
    buttons = _buttons(q, listed)
    own = listed is not None
    keys = [at for _, at in buttons] if own else list(range(1, len(buttons) + 1))
    counts = [_key_has_text(q, one) for one in listed or () if _is_button(one)]
    texts = [f" [{n}: {name}]" for n, (name, _) in zip(keys, buttons, strict=True)]
    yield p.Message((*_shown_texts(q), e.Text("".join(texts))))
    if not buttons and answer is not None:
        raise NotExpressible
    if buttons:
        values = [e.Number(value) for _, value in buttons]
        yield from operator_texts.asked_for_key(answer, keys, values, counts)


def _option_elements(q: VendorCall, option: str) -> Sequence[s.Expression] | None:
    """The elements of an array that an option is given; None for none of a known size."""
    match q.call.options.get(option):
        case s.AggregateNode(items):
            return items
        case s.NameRef(name) as array if len(size := q.sizes.get(name.lower(), ())) == 1:
            places = (s.NumberLiteral(str(at)) for at in range(1, size[0] + 1))
            return [s.Element(array, (place,)) for place in places]
    return None


def _buttons(q: VendorCall, own: Sequence[s.Expression] | None) -> list[tuple[str, int]]:
    """The names of the buttons of a box, and what each gives. own: those that a box lists."""
    if own is not None:
        return [(_button_text(one), at) for at, one in enumerate(own, 1) if _is_button(one)]
    node = q.call.options.get("buttons")
    known = _BUTTONS.get("btnok" if node is None else name_of(node).lower())
    if "btnarray" in q.call.options or known is None:
        raise NotExpressible(_COMPUTED_TEXT)
    return [(one.removeprefix("res"), BUTTON_ANSWERS[one.lower()]) for one in known]


def _is_button(button: s.Expression) -> bool:
    """True if an element is a button: an empty text is not."""
    return button != s.StringLiteral("") and name_of(button).lower() != _EMPTY_TEXT


def _button_text(button: s.Expression) -> str:
    """Return the text of a button, as far as it is known before the program runs."""
    return button.value if isinstance(button, s.StringLiteral) else printed(button)


def _shown_texts(q: VendorCall) -> tuple[e.Expression, ...]:
    first = [q.given(0)] if q.answer is None else []
    first += [q.value(item) for item in _option_elements(q, "msgarray") or ()]
    lines = [q.option("header"), *first, *(q.option(name) for name in LINES[1:])]
    return _joined_lines([line for line in lines if line is not None])


_LOWERINGS: Final[Mapping[str, Callable[[VendorCall], Replacement]]] = {
    "break": _stop_statement,
    "stop": _stop_statement,
    "errwrite": _error_message,
    "errlog": _event_message,
    "tpreadfk": _key_question,
    "tpreadnum": _number_question,
    "tpreaddnum": _number_question,
    "uimsgbox": _message_box,
    "uimessagebox": _message_box,
    "uinumentry": _number_entry,
    "uidnumentry": _number_entry,
}
"""By lower-case names of instructions and functions."""

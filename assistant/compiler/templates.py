"""Fill in templates of programs; each line comes with the line of the template that wrote it.

A template that only names sections and values is filled in here. Jinja2 fills in any other, in its
sandbox: templates come from files of a project, and never run as programs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from assistant.base.budgets import TEMPLATE, budget_factor, within
from assistant.base.diagnostics import Diagnostic, Refused, Rule, Span, error, near_names
from assistant.base.source_text import SourceText

if TYPE_CHECKING:
    from jinja2.sandbox import SandboxedEnvironment

TEMPLATE_UNREADABLE: Final = error(
    "CO601",
    "the template cannot be read: {reason}",
    "correct the line: `{{{{ author }}}}` writes a value, and each `{{% if author %}}` needs its"
    " end",
)
TEMPLATE_WITHOUT_VALUE: Final = error(
    "CO602", "the template names `{name}`, which is not a value of programs", "write {known}"
)
TEMPLATE_FAILED: Final = error(
    "CO603",
    "the template cannot be filled in: {reason}",
    "write only values and filters: a template runs no functions and reads no files",
)
TEMPLATE_TOO_LONG: Final = error(
    "CO604",
    "the template writes more than {most:,} characters around a program",
    "shorten it: it holds the comments and the frame, no statements",
)
NOT_WRITABLE: Final = error(
    "CO617",
    "the template writes `{character}`, which is no printable character of ASCII",
    "write it in ASCII; values such as `{{{{ author }}}}` are converted",
)

MOST_TEMPLATE_TEXT: Final = 200_000
"""Characters that a template may write, sections not counted."""
SAFE_FILTERS: Final = (
    *("capitalize", "d", "default", "first", "join", "last", "length", "lower", "replace", "sort"),
    *("title", "trim", "unique", "upper"),
)
"""Filters whose results are as long as what they are given, or nearly."""
_PLACEHOLDER: Final = re.compile(r"\{\{ *([a-z]+) *\}\}")
_OPENS, _CLOSES = "\ue000", "\ue001"
_MARK_OPENS, _MARK_CLOSES = "\ue002", "\ue003"
_LINE_MARKS: Final = re.compile(f"{_MARK_OPENS}([0-9]{{1,9}}){_MARK_CLOSES}")
PRIVATE_CHARACTERS: Final = re.compile("[\ue000-\ue003]")
"""Characters of placeholders and marks while a template is filled in."""
_SECTION: Final = re.compile(f"{_OPENS}(.*?){_CLOSES}")


class Section(str):
    """Placeholder for the text of a section; false if that text is empty."""

    __slots__ = ("empty",)
    empty: bool

    def __bool__(self) -> bool:
        return not self.empty


def section_placeholder(name: str, text: str) -> Section:
    made = Section(f"{_OPENS}{name}{_CLOSES}")
    made.empty = not text
    return made


def section_on(line: str) -> str | None:
    """Return the section whose placeholder a line is, None for any other line."""
    match = _SECTION.fullmatch(line.strip())
    return match[1] if match else None


def with_placeholder_names(line: str) -> str:
    """Return a line with `{{ name }}` for each placeholder, as its author wrote it."""
    return _SECTION.sub(lambda match: f"{{{{ {match[1]} }}}}", line)


def escaped_character(character: str) -> str:
    """A character as a finding shows it."""
    return character if character.isprintable() else f"\\x{ord(character):02x}"


def finding_at_line(template: SourceText, line: int, rule: Rule, **fields: Any) -> Diagnostic:
    """The rule's finding at a line of a template."""
    lines = template.text.split("\n")
    line = min(max(line, 1), len(lines))
    start = sum(len(one) + 1 for one in lines[: line - 1])
    end = start + len(lines[line - 1].rstrip())
    return template.finding(rule, Span(start, max(end, start)), **fields)


def fill_template(template: SourceText, values: Mapping[str, str]) -> list[tuple[int, str]]:
    """The lines that a template writes, each with the line of the template that it comes from.

    Raises Refused for a template that cannot be read or filled in.
    """
    if own := PRIVATE_CHARACTERS.search(template.text):
        line, character = template.text.count("\n", 0, own.start()) + 1, escaped_character(own[0])
        raise Refused(finding_at_line(template, line, NOT_WRITABLE, character=character))
    known = set(_PLACEHOLDER.findall(template.text)) <= values.keys()
    if known and not re.search(r"\{[{%#]", _PLACEHOLDER.sub("", template.text)):
        if len(template.text) > MOST_TEMPLATE_TEXT:
            raise Refused(finding_at_line(template, 1, TEMPLATE_TOO_LONG, most=MOST_TEMPLATE_TEXT))
        said = _PLACEHOLDER.sub(lambda match: values[match[1]], template.text)
        return [(at, line.rstrip()) for at, line in enumerate(_numbered_lines(said), 1)]
    with within(TEMPLATE, template.path, len(template.text)):
        return _by_jinja(template, values)


def _numbered_lines(text: str) -> list[str]:
    return text.removesuffix("\n").replace("\r\n", "\n").split("\n") if text else []


def _by_jinja(template: SourceText, values: Mapping[str, str]) -> list[tuple[int, str]]:
    from jinja2 import TemplateError, TemplateSyntaxError, UndefinedError

    try:
        made = jinja_environment().from_string(template.text)
        text = "".join(_within_limit(template, made.generate(values)))
    except TemplateSyntaxError as wrong:
        reason = wrong.message or "it is not finished"
        raise Refused(
            finding_at_line(template, wrong.lineno, TEMPLATE_UNREADABLE, reason=reason)
        ) from None
    except SyntaxError as wrong:  # of the Python that Jinja2 makes of it
        raise Refused(finding_at_line(template, 1, TEMPLATE_UNREADABLE, reason=wrong.msg)) from None
    except UndefinedError as wrong:
        at = _line_of(wrong)
        name = re.search(r"'(.*?)' is undefined", wrong.message or "")
        if name is None:
            reason = wrong.message or "a value is missing"
            raise Refused(finding_at_line(template, at, TEMPLATE_FAILED, reason=reason)) from None
        near = near_names(name[1], list(values))
        fields = {"name": name[1], "known": " or ".join(f"`{one}`" for one in near or values)}
        raise Refused(finding_at_line(template, at, TEMPLATE_WITHOUT_VALUE, **fields)) from None
    except (TemplateError, TypeError, ValueError, ArithmeticError, LookupError) as wrong:
        if isinstance(wrong, Refused | OverflowError):
            raise
        reason = str(wrong) or type(wrong).__name__
        raise Refused(
            finding_at_line(template, _line_of(wrong), TEMPLATE_FAILED, reason=reason)
        ) from None
    found, at = [], 1
    for line in _numbered_lines(text):
        if marks := _LINE_MARKS.findall(line):
            at = int(marks[0])
        found.append((at, _LINE_MARKS.sub("", line).rstrip()))
    if found and not found[-1][1]:
        found.pop()  # the mark after the last line end
    return found


def _within_limit(template: SourceText, pieces: Iterator[str]) -> Iterator[str]:
    most = MOST_TEMPLATE_TEXT * max(1, budget_factor())
    length, at = 0, 1
    for piece in pieces:
        if marks := _LINE_MARKS.findall(piece):
            at = int(marks[-1])
        length += len(_LINE_MARKS.sub("", piece))
        if length > most:
            raise Refused(finding_at_line(template, at, TEMPLATE_TOO_LONG, most=int(most)))
        yield piece


def _line_of(raised: BaseException) -> int:
    """Return the line of the template in which an exception was raised."""
    found, trace = 1, raised.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == "<template>":
            found = trace.tb_lineno
        elif (made := trace.tb_frame.f_globals.get("__jinja_template__")) is not None:
            found = made.get_corresponding_lineno(trace.tb_lineno)
        trace = trace.tb_next
    return found


@cache
def jinja_environment() -> SandboxedEnvironment:
    """Jinja2 for untrusted templates: no functions, no files, no arithmetic without end."""
    from jinja2 import StrictUndefined
    from jinja2.exceptions import SecurityError
    from jinja2.ext import Extension
    from jinja2.lexer import Token, TokenStream
    from jinja2.runtime import Context, Macro
    from jinja2.sandbox import SandboxedEnvironment

    class Lines(Extension):
        """Marks each line of the text of a template with its number."""

        def filter_stream(self, stream: TokenStream) -> Iterator[Token]:
            for token in stream:
                if token.type != "data":
                    yield token
                    continue
                lines = token.value.split("\n")
                marked = (
                    f"{_MARK_OPENS}{token.lineno + at}{_MARK_CLOSES}{line}"
                    for at, line in enumerate(lines)
                )
                yield Token(token.lineno, "data", "\n".join(marked))

    class Sandbox(SandboxedEnvironment):
        intercepted_binops = frozenset(("*", "**", "%"))

        def is_safe_callable(self, obj: Any) -> bool:
            return isinstance(obj, Macro)

        def call_binop(self, context: Context, operator: str, left: Any, right: Any) -> Any:
            small = all(type(one) is int and abs(one) < 1_000_000 for one in (left, right))
            if operator == "**" or not small:
                raise SecurityError(f"`{operator}` is only for small whole numbers")
            return super().call_binop(context, operator, left, right)

    made = Sandbox(
        extensions=[Lines],
        undefined=StrictUndefined,
        autoescape=False,  # programs, no pages: values are made safe for comments
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.globals.clear()
    made.filters = {name: made.filters[name] for name in SAFE_FILTERS}
    return made

"""Style of written programs: templates for the lines around their statements, and the form of
programs that are made from drawings and tables.

    [style]                       # in assistant.toml
    template = "style"            # folder with rapid/module.mod.j2 or melfa/program.prg.j2
    project = "Line 3, station 2"
    author = "Process engineering"
    revision = "B"
    procedures = "contour"        # this and below: see `process.ProgramStyle`
    comments = true
    points = "targets"
    constants = true

A template writes comments and the frame of a module, and places the sections of the text. All
statements come from the printer of the language, and the complete text is read back. A template
that only names sections and values is filled in here; Jinja2 fills in any other, in its sandbox:
templates come from files of a project, and never run as programs. Each line is known with the line
of the template that wrote it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from functools import cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.budgets import SETTINGS_FILE, TEMPLATE, budget_factor, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Span,
    Unreadable,
    error,
)
from assistant.base.near_names import near_names
from assistant.base.source_text import (
    NOT_FOUND,
    SourceText,
    decode,
    encode,
    in_ascii,
    is_file,
    is_folder,
    one_line,
    read_bytes,
)
from assistant.program import settings_tables as kinds
from assistant.program.program import Program
from assistant.program.project_file import STYLE, project_of
from assistant.program.rewriting import map_bodies
from assistant.program.settings_tables import Page, Table
from assistant.program.statements import Comment
from assistant.resources import resource
from assistant.sources.process import NO_STYLE, ProgramStyle
from assistant.sources.process import STYLE_KEYS as FORM_KEYS

if TYPE_CHECKING:
    from jinja2.sandbox import SandboxedEnvironment

    from assistant.languages import Language
    from assistant.languages.language_types import Numbering, Outline


_TEMPLATE_UNREADABLE: Final = error(
    "CO601",
    "the template cannot be read: {reason}",
    "correct the line: `{{{{ author }}}}` writes a value, and each `{{% if author %}}` needs its"
    " end",
)
_TEMPLATE_WITHOUT_VALUE: Final = error(
    "CO602", "the template names `{name}`, which is not a value of programs", "write {known}"
)
_TEMPLATE_FAILED: Final = error(
    "CO603",
    "the template cannot be filled in: {reason}",
    "write only values and filters: a template runs no functions and reads no files",
)
_TEMPLATE_TOO_LONG: Final = error(
    "CO604",
    "the template writes more than {most:,} characters around a program",
    "shorten it: it holds the comments and the frame, no statements",
)
_NOT_WRITABLE: Final = error(
    "CO617",
    "the template writes `{character}`, which is no printable character of ASCII",
    "write it in ASCII; values such as `{{{{ author }}}}` are converted",
)

_MOST_TEMPLATE_TEXT: Final = 200_000
"""Characters that a template may write, sections not counted."""
_SAFE_FILTERS: Final = (
    *("capitalize", "d", "default", "first", "join", "last", "length", "lower", "replace", "sort"),
    *("title", "trim", "unique", "upper"),
)
"""Filters whose results are as long as what they are given, or nearly."""
_PLACEHOLDER: Final = re.compile(r"\{\{ *([a-z]+) *\}\}")
_OPENS, _CLOSES = "\ue000", "\ue001"
_MARK_OPENS, _MARK_CLOSES = "\ue002", "\ue003"
_LINE_MARKS: Final = re.compile(f"{_MARK_OPENS}([0-9]{{1,9}}){_MARK_CLOSES}")
_PRIVATE_CHARACTERS: Final = re.compile("[\ue000-\ue003]")
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
    # The characters of placeholders must not come from the template itself.
    if own := _PRIVATE_CHARACTERS.search(template.text):
        line, character = template.text.count("\n", 0, own.start()) + 1, escaped_character(own[0])
        raise Refused(finding_at_line(template, line, _NOT_WRITABLE, character=character))
    known = set(_PLACEHOLDER.findall(template.text)) <= values.keys()
    # Nothing but placeholders: no need for Jinja2.
    if known and not re.search(r"\{[{%#]", _PLACEHOLDER.sub("", template.text)):
        if len(template.text) > _MOST_TEMPLATE_TEXT:
            raise Refused(
                finding_at_line(template, 1, _TEMPLATE_TOO_LONG, most=_MOST_TEMPLATE_TEXT)
            )
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
            finding_at_line(template, wrong.lineno, _TEMPLATE_UNREADABLE, reason=reason)
        ) from None
    except SyntaxError as wrong:  # of the Python that Jinja2 makes of it
        raise Refused(
            finding_at_line(template, 1, _TEMPLATE_UNREADABLE, reason=wrong.msg)
        ) from None
    except UndefinedError as wrong:
        at = _line_of(wrong)
        name = re.search(r"'(.*?)' is undefined", wrong.message or "")
        if name is None:
            reason = wrong.message or "a value is missing"
            raise Refused(finding_at_line(template, at, _TEMPLATE_FAILED, reason=reason)) from None
        near = near_names(name[1], list(values))
        fields = {"name": name[1], "known": " or ".join(f"`{one}`" for one in near or values)}
        raise Refused(finding_at_line(template, at, _TEMPLATE_WITHOUT_VALUE, **fields)) from None
    except (TemplateError, TypeError, ValueError, ArithmeticError, LookupError) as wrong:
        # Refused is a ValueError; `within` turns OverflowError into a finding.
        if isinstance(wrong, Refused | OverflowError):
            raise
        reason = str(wrong) or type(wrong).__name__
        raise Refused(
            finding_at_line(template, _line_of(wrong), _TEMPLATE_FAILED, reason=reason)
        ) from None
    found, at = [], 1
    for line in _numbered_lines(text):
        # A line without a mark comes from the same line of the template as the one before.
        if marks := _LINE_MARKS.findall(line):
            at = int(marks[0])
        found.append((at, _LINE_MARKS.sub("", line).rstrip()))
    if found and not found[-1][1]:
        found.pop()  # the mark after the last line end
    return found


def _within_limit(template: SourceText, pieces: Iterator[str]) -> Iterator[str]:
    most = _MOST_TEMPLATE_TEXT * max(1, budget_factor())
    length, at = 0, 1
    for piece in pieces:
        if marks := _LINE_MARKS.findall(piece):
            at = int(marks[-1])
        length += len(_LINE_MARKS.sub("", piece))
        if length > most:
            raise Refused(finding_at_line(template, at, _TEMPLATE_TOO_LONG, most=int(most)))
        yield piece


def _line_of(raised: BaseException) -> int:
    """Return the line of the template in which an exception was raised."""
    found, trace = 1, raised.__traceback__
    while trace is not None:
        # A rewritten traceback has the lines of the template, an original one those of the compiled
        # module.
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
        # A short template could ask for gigabytes or hours with these.
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
    # Without globals such as `range`, a template calls nothing but its own macros.
    made.globals.clear()
    made.filters = {name: made.filters[name] for name in _SAFE_FILTERS}
    return made


_NOT_A_COMMENT: Final = error(
    "CO611",
    "the template writes `{text}`, which is not a comment: statements come only from the program",
    "begin the line with `{mark}`, or remove it",
)
_SECTION_LEFT_OUT: Final = error(
    "CO612",
    "the template leaves `{name}` out, so the program would lose it",
    "write {example} on a separate line",
)
_SECTION_TWICE: Final = error(
    "CO613", "the template writes `{name}` twice", "remove one of the two lines"
)
_SECTION_NOT_ALONE: Final = error(
    "CO614",
    "the template writes `{text}`: the section shares its line with other text, or was changed",
    "write the section on a separate line, as `{{{{ header }}}}`",
)
_SECTION_OUT_OF_ORDER: Final = error(
    "CO615",
    "`{name}` is below `{other}`, where {language} does not read it",
    "move it above `{other}`",
)
_READ_AS_ITEM: Final = error(
    "CO616",
    "the comment `{text}` would be read as a statement about the program",
    "put another word in front of it",
)
_TEMPLATE_CHANGES_PROGRAM: Final = error(
    "CO618",
    "with the lines of the template, the program is read back differently: {reason}",
    "correct or remove the line; without the template the program is proven",
)
_NO_TEMPLATE: Final = error(
    "CO619",
    "`{folder}` is not a folder of the project with a template",
    "write {files} there, or name another folder of the project",
)

_LONGEST_VALUE: Final = 120
"""Characters of a value in a comment."""
_STYLE_TEXTS: Final = ("project", "author", "revision")
"""Values that a project gives its templates."""
STYLE_KEYS: Final[Mapping[str, Callable[[Any], Any]]] = {
    **dict.fromkeys(("template", *_STYLE_TEXTS), kinds.text),
    **FORM_KEYS,
}


@dataclass(frozen=True, slots=True)
class Style:
    """folder: of the project's templates, None for those of this package. values: of TEXTS.
    drawings: the form of programs that are made from drawings, where their process file states
    none.
    """

    folder: FilePath | None = None
    values: Mapping[str, str] = field(default_factory=dict)
    form: ProgramStyle = NO_STYLE

    def template(self, outline: Outline) -> tuple[SourceText, bool]:
        """Return the template for a language, and whether the project has it.

        Raises Unreadable for a file that cannot be read.
        """
        if self.folder is None:
            return _default_template(outline.template), False
        file = self.folder / outline.template
        try:
            data = read_bytes(file, allow_empty=True, most=SETTINGS_FILE)
        except Unreadable as unreadable:
            if unreadable.findings[0].code != NOT_FOUND.code:
                raise
            # `build` notes the files that are opened: a new template has the program made anew.
            with suppress(FileNotFoundError):
                file.open("rb").close()
            return _default_template(outline.template), False
        source = decode(data, _shown_path(file), ("utf-8-sig", "utf-8"))
        return replace(source, text=source.text.replace("\r\n", "\n")), True


def _shown_path(file: FilePath) -> str:
    here = FilePath.cwd()
    return str(file.relative_to(here)) if file.is_relative_to(here) else str(file)


@cache
def _default_template(name: str) -> SourceText:
    return SourceText(resource("templates", name).read_text(encoding="utf-8"), f"templates/{name}")


PLAIN_STYLE: Final = Style()


def style_of(folder: FilePath) -> Style:
    """Return the style of the project of a folder.

    Raises Unreadable for a project file that cannot be read, and Refused (exit status 2) for a
    style that is wrong.
    """
    project = project_of(folder.absolute())
    content = project.content if project is not None else None
    if project is None or not isinstance(content, Mapping) or STYLE not in content:
        return PLAIN_STYLE
    page = Page(project.source, project.spans)
    given = Table(page, project.table, content).table(STYLE)
    read = given.read(STYLE_KEYS)
    at = FilePath(project.source.path or "").absolute().parent
    where = None
    if "template" in read:
        where = _template_folder(at, given, read["template"])
    if page.findings:
        raise Refused(*page.findings, exit_status=2)
    form = ProgramStyle(**{key: read[key] for key in FORM_KEYS if key in read})
    return Style(where, {key: read[key] for key in _STYLE_TEXTS if key in read}, form)


def _template_folder(at: FilePath, table: Table, text: str) -> FilePath | None:
    """Return the folder of templates; None, with a finding, if it is not one of the project."""
    from assistant import languages

    outlines = (languages.get(name).outline() for name in languages.names())
    files = list(dict.fromkeys(one.template for one in outlines if one is not None))
    folder = (at / text.replace("\\", "/")).resolve()
    inside = "\0" not in text and folder.is_relative_to(at.resolve())
    if inside and is_folder(folder) and any(is_file(folder / one) for one in files):
        return folder
    named = " or ".join(f"`{one}`" for one in files)
    table.say(_NO_TEMPLATE, "template", folder=kinds.shown(text), files=named)
    return None


def style_beside(program: Program, text: SourceText | None, path: FilePath | None) -> Style:
    """Return the style of the project that contains the source of a program.

    path: of the source; None for that of its text, or of the files that it was lifted from.
    """
    if path is None:
        trees = program.origin.trees if program.origin is not None else ()
        texts = [text, *(tree.source for tree in trees)]
        found = next((one.path for one in texts if one is not None and one.path), None)
        path = None if found is None else FilePath(found)
    return PLAIN_STYLE if path is None else style_of(path.absolute().parent)


# ------------------------------------------------------------------------------ programs


@dataclass(frozen=True, slots=True)
class StyledText:
    """A file in its style.

    lines: number of each line of the file that the template wrote → number of the line in the
    template; empty for the default template, which adds none.
    """

    data: bytes
    template: SourceText
    lines: Mapping[int, int] = field(default_factory=dict)


def apply_style(
    data: bytes, language: Language[Any], style: Style, program: Program, unit: str | None
) -> StyledText:
    """Return the text of a unit in the frame of the style; raises Refused."""
    outline = language.outline()
    if outline is None:
        return StyledText(data, SourceText(""))
    template, own = style.template(outline)
    # The default template shows the frame that files have anyway, so a user can start from it.
    if not own:
        return StyledText(data, template)
    source = language.decode(data)
    text = source.text
    sections = dict(outline.sections(text))
    name = outline.name(text)
    known = {key: section_placeholder(key, sections[key]) for key in sections}
    for key, (whole, _) in outline.within.items():
        known[key] = section_placeholder(key, sections[whole])
    stated = {
        "name": name or unit or program.name,
        "program": program.name,
        "unit": unit or "",
        "robot": program.robot or "",
        "language": language.title,
        **{key: style.values.get(key, "") for key in _STYLE_TEXTS},
    }
    written = fill_template(template, {**{k: comment_value(v) for k, v in stated.items()}, **known})
    _check(written, template, language, outline, name)
    for key, (whole, part) in outline.within.items():
        sections[key] = part(sections[whole])
    numbering = outline.numbered(language.name)
    made, lines = _assembled_text(written, sections, source, outline, numbering)
    return StyledText(encode(made), template, lines)


def comment_value(value: str) -> str:
    """Return a value as one line of ASCII of at most LONGEST characters, for a comment."""
    plain = in_ascii(one_line(value))
    plain = "".join(c if " " <= c <= "~" else " " for c in plain)
    return " ".join(plain.split())[:_LONGEST_VALUE].strip()


def _check(
    written: Sequence[tuple[int, str]],
    template: SourceText,
    language: Language[Any],
    outline: Outline,
    name: str,
) -> None:
    """Raise Refused where a template writes other lines than comments, frame and sections."""
    found: list[Diagnostic] = []
    seen: dict[str, int] = {}
    last = ""

    def say(at: int, rule: Rule, **fields: Any) -> None:
        found.append(finding_at_line(template, at, rule, **fields))

    for at, line in written:
        if not line.strip():
            continue
        part = section_on(line)
        odd = next((c for c in line if not " " <= c <= "~"), None) if part is None else None
        if odd is not None and not _PRIVATE_CHARACTERS.search(line):
            say(at, _NOT_WRITABLE, character=escaped_character(odd))
            continue
        part = part or _is_frame_line(line, outline, name)
        if part is not None and part in outline.rank:
            if part in seen:
                say(at, _SECTION_TWICE, name=part)
            elif last and outline.rank[part] < outline.rank[last]:
                say(at, _SECTION_OUT_OF_ORDER, name=part, other=last, language=language.title)
            else:
                last = part
            seen.setdefault(part, at)
        elif _PRIVATE_CHARACTERS.search(line):
            say(at, _SECTION_NOT_ALONE, text=with_placeholder_names(line))
        else:
            comment = line.strip().removeprefix(language.comment_mark)
            if not line.strip().startswith(language.comment_mark):
                say(at, _NOT_A_COMMENT, text=line.strip(), mark=language.comment_mark)
            elif outline.item(comment):
                say(at, _READ_AS_ITEM, text=comment.strip())
            elif _is_after_sections(last, outline):
                say(
                    at,
                    _SECTION_OUT_OF_ORDER,
                    name=line.strip(),
                    other=last,
                    language=language.title,
                )
    # The complete set of sections that the template comes nearest to decides which are missing.
    whole = max(outline.complete, key=lambda parts: len(seen.keys() & set(parts)))
    for part in whole:
        if part not in seen:
            example = f"`{part}`" if part in outline.frame else f"`{{{{ {part} }}}}`"
            if part in outline.frame and "{name}" in outline.frame[part]:
                example = f"`{part} {{{{ name }}}}`"
            say(len(template.text.split("\n")), _SECTION_LEFT_OUT, name=part, example=example)
    for part, at in seen.items():
        if part not in whole:
            say(at, _SECTION_TWICE, name=part)
    if found:
        raise Refused(*found)


def _is_after_sections(last: str, outline: Outline) -> bool:
    """True after the last section above which a language takes comments of a template."""
    return bool(last and outline.ends) and outline.rank[last] >= outline.rank[outline.ends]


def _is_frame_line(line: str, outline: Outline, name: str) -> str | None:
    for part, pattern in outline.frame.items():
        if re.fullmatch(pattern.replace("{name}", re.escape(name)), line.strip()):
            return part
    return None


def _assembled_text(
    written: Sequence[tuple[int, str]],
    sections: Mapping[str, str],
    source: SourceText,
    outline: Outline,
    numbering: Numbering | None,
) -> tuple[SourceText, dict[int, int]]:
    """Return the text with its sections, and the lines in it that the template wrote."""
    newline = "\r\n" if "\r\n" in source.text else "\n"
    pieces: list[str] = []
    lines: dict[int, int] = {}
    number = 1
    for at, line in written:
        part = section_on(line)
        if part is not None:
            pieces.append(sections[part])
            number += sections[part].count("\n")
        elif line or outline.blank:
            pieces.append(line + newline)
            lines[number] = at
            number += 1
    text = "".join(pieces)
    if lines and numbering is not None:
        text = newline.join([*numbering(text.removesuffix(newline).split(newline)), ""])
    return replace(source, text=text), lines


# ------------------------------------------------------------------------------ the proof


def without_comments(program: Program) -> Program:
    """Return a program without comments: the comments of a template are read back as its own."""

    def body(statements: Sequence[Any]) -> tuple[Any, ...]:
        kept = (one for one in statements if not isinstance(one, Comment))
        return tuple(map_bodies(one, body) for one in kept)

    procedures = tuple(replace(one, body=body(one.body)) for one in program.procedures)
    return replace(program, comments=(), procedures=procedures)


def findings_of_templates(
    findings: Sequence[Diagnostic], files: Mapping[str, StyledText]
) -> list[Diagnostic]:
    """Return the faults of texts that are sound without their template, at lines of it."""
    found: dict[Diagnostic, None] = {}
    for finding in findings:
        styled = files.get(finding.path or "") or next(iter(files.values()))
        line = styled.lines.get(finding.line or 0, 1)
        found[
            finding_at_line(
                styled.template, line, _TEMPLATE_CHANGES_PROGRAM, reason=finding.message
            )
        ] = None
    return list(found)

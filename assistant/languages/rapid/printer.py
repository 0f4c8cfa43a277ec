"""The typed tree to text, in one canonical layout."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from assistant.languages.rapid import syntax as s
from assistant.languages.rapid.runs import moves_text, targets_text

INDENT: Final = "  "
NEWLINE: Final = "\r\n"


def print_file(file: s.File, newline: str = NEWLINE) -> str:
    """The whole file; an unchanged module of a file that was read as it stood there."""
    known = file.origin.parts if file.origin else ()
    pieces = [] if file.header is None else [f"%%%{file.header}%%%{newline}"]
    for part in file.parts:
        if any(part is old for old in known) and part.span and file.origin:
            text = file.origin.source.text[part.span.start : part.span.end]
            pieces.append(text.rstrip() + newline)
        else:
            pieces.append(print_part(part, newline))
    return "".join(pieces)


def print_part(part: s.Module | s.CommentLine, newline: str = NEWLINE) -> str:
    if isinstance(part, s.CommentLine):
        return comment(part) + newline
    return "".join(Printer(newline).module(part))


def print_items(items: Iterable[s.Item], newline: str = "\n") -> str:
    """Declarations as text of their own, without a last line end."""
    return "".join(Printer(newline).items(tuple(items), "")).strip("\r\n")


def print_statements(body: Iterable[s.StatementNode], newline: str = "\n") -> str:
    """Statements as text of their own, without a last line end."""
    return "".join(Printer(newline).body(tuple(body), "")).strip("\r\n")


def comment(node: s.CommentLine) -> str:
    r"""The comment on one line; whatever could end the line becomes a blank."""
    text = " ".join(node.text.split("\n")).replace("\r", " ").strip()
    text = "".join(c if c.isprintable() else " " for c in text).strip()
    return f"! {text}" if text else "!"


class Printer:
    """Lines of the canonical layout; `body` and `items` give what stands in a block."""

    def __init__(self, newline: str) -> None:
        self.newline = newline

    def line(self, indent: str, text: str) -> str:
        return indent + text + self.newline

    def module(self, module: s.Module) -> Iterator[str]:
        attributes = f"({','.join(module.attributes)})" if module.attributes else ""
        yield self.line("", f"MODULE {module.name}{attributes}")
        yield from self.items(module.items, INDENT)
        yield self.line("", "ENDMODULE")

    def items(self, items: tuple[s.Item, ...], indent: str) -> Iterator[str]:
        blank = False
        for text in self._with_trailing(items, indent):
            routine = text.startswith("\0")
            if routine and blank:
                yield self.newline
            blank = True
            yield text.removeprefix("\0")

    def _with_trailing(self, items: tuple[s.Item, ...], indent: str) -> Iterator[str]:
        held = ""
        for item in items:
            if isinstance(item, s.CommentLine) and item.trailing and held:
                held = held.removesuffix(self.newline) + self.line(" ", comment(item))
                continue
            if held:
                yield held
            held = "".join(self.item(item, indent))
        if held:
            yield held

    def item(self, item: s.Item, indent: str) -> Iterator[str]:
        match item:
            case s.Routine():
                yield "\0"
                yield from self.routine(item, indent)
            case s.Record():
                local = "LOCAL " if item.local else ""
                yield self.line(indent, f"{local}RECORD {item.name}")
                for type, name in item.components:
                    yield self.line(indent + INDENT, f"{type} {name};")
                yield self.line(indent, "ENDRECORD")
            case s.Alias():
                local = "LOCAL " if item.local else ""
                yield self.line(indent, f"{local}ALIAS {item.type} {item.name};")
            case _:
                yield from self.statement(item, indent)

    def routine(self, r: s.Routine, indent: str) -> Iterator[str]:
        local = "LOCAL " if r.local else ""
        type = f"{r.type} " if r.kind == "FUNC" else ""
        parameters = "" if r.kind == "TRAP" else f"({self.parameters(r.parameters)})"
        yield self.line(indent, f"{local}{r.kind} {type}{r.name}{parameters}")
        yield from self.body(r.body, indent + INDENT)
        for handler in r.handlers:
            numbers = ",".join(expression(n) for n in handler.numbers)
            yield self.line(indent, handler.kind + (f" ({numbers})" if numbers else ""))
            yield from self.body(handler.body, indent + INDENT)
        yield self.line(indent, f"END{r.kind}")

    def parameters(self, groups: tuple[s.ParameterGroup, ...]) -> str:
        text = ""
        for group in groups:
            inner = "|".join(self.parameter(p) for p in group.alternatives)
            if group.optional:
                text += "\\" + inner
            else:
                text += ("," if text else "") + inner
        return text

    def parameter(self, p: s.ParameterNode | s.Placeholder) -> str:
        if isinstance(p, s.Placeholder):
            return p.text
        array = "{<DIM>}" if p.dimensions < 0 else "{" + ",".join("*" * p.dimensions) + "}"
        mode = p.mode + " " if p.mode else ""
        return f"{mode}{p.type} {p.name}{array if p.dimensions else ''}"

    def body(self, body: tuple[s.StatementNode, ...], indent: str) -> Iterator[str]:
        held = ""
        for node in body:
            if isinstance(node, s.CommentLine) and node.trailing and held:
                held = held.removesuffix(self.newline) + self.line(" ", comment(node))
                continue
            if held:
                yield held
            held = "".join(self.statement(node, indent))
        if held:
            yield held

    def statement(self, node: s.StatementNode | s.Item, indent: str) -> Iterator[str]:
        match node:
            case s.IfThen():
                word = "IF"
                for branch in node.branches:
                    if branch.condition is None:
                        yield self.line(indent, "<EIT>")
                        continue
                    yield self.line(indent, f"{word} {expression(branch.condition)} THEN")
                    yield from self.body(branch.body, indent + INDENT)
                    word = "ELSEIF"
                if node.otherwise is not None:
                    yield self.line(indent, "ELSE")
                    yield from self.body(node.otherwise, indent + INDENT)
                yield self.line(indent, "ENDIF")
            case s.ForLoop():
                step = f" STEP {expression(node.step)}" if node.step is not None else ""
                bounds = f"{expression(node.first)} TO {expression(node.last)}"
                yield self.line(indent, f"FOR {node.variable} FROM {bounds}{step} DO")
                yield from self.body(node.body, indent + INDENT)
                yield self.line(indent, "ENDFOR")
            case s.WhileLoop():
                yield self.line(indent, f"WHILE {expression(node.condition)} DO")
                yield from self.body(node.body, indent + INDENT)
                yield self.line(indent, "ENDWHILE")
            case s.TestOf():
                yield self.line(indent, f"TEST {expression(node.subject)}")
                for case in node.cases:
                    values = ",".join(expression(v) for v in case.values)
                    yield self.line(indent, f"CASE {values}:" if values else "<CSE>")
                    yield from self.body(case.body, indent + INDENT)
                if node.otherwise is not None:
                    yield self.line(indent, "DEFAULT:")
                    yield from self.body(node.otherwise, indent + INDENT)
                yield self.line(indent, "ENDTEST")
            case s.TargetRunNode():
                yield targets_text(node.run, node.scope, indent, self.newline)
            case s.MoveRunNode():
                yield moves_text(node.run, indent, self.newline)
            case s.LabelMark():
                yield self.line(indent[:-2], f"{node.name}:")
            case s.CommentLine():
                yield self.line(indent, comment(node))
            case s.CompactIf():
                inner = "".join(self.statement(node.statement, ""))
                yield self.line(indent, f"IF {expression(node.condition)} " + inner.rstrip("\r\n"))
            case s.Placeholder():
                yield self.line(indent, node.text)
            case _:
                yield self.line(indent, simple(node) + ";")


def simple(node: s.StatementNode | s.Item) -> str:
    """A statement or declaration of one line, without its `;`."""
    match node:
        case s.Data():
            scope = node.scope + " " if node.scope else ""
            dims = ",".join(expression(d) for d in node.dimensions)
            size = "{" + dims + "}" if dims else ""
            value = f":={expression(node.value)}" if node.value is not None else ""
            return f"{scope}{node.storage} {node.type} {node.name}{size}{value}"
        case s.Assignment():
            return f"{expression(node.target)}:={expression(node.value)}"
        case s.ProcedureCall(name=str(name)):
            given = arguments(node.arguments)
            return name + ("" if given.startswith("\\") or not given else " ") + given
        case s.ProcedureCall(name=late):
            given = arguments(node.arguments)
            assert not isinstance(late, str)
            return (
                f"%{expression(late)}%"
                + ("" if given.startswith("\\") or not given else " ")
                + given
            )
        case s.GotoLabel():
            return f"GOTO {node.label}"
        case s.ReturnFrom():
            return "RETURN" + (f" {expression(node.value)}" if node.value is not None else "")
        case s.RaiseError():
            return "RAISE" + (f" {expression(node.value)}" if node.value is not None else "")
        case s.Word():
            return node.word
        case s.Connect():
            return f"CONNECT {expression(node.interrupt)} WITH {node.trap}"
    raise TypeError(f"no simple statement: {type(node).__name__}")


def arguments(given: tuple[s.Argument, ...]) -> str:
    text = ""
    for argument in given:
        match argument:
            case s.Positional():
                name = f"{argument.name}:=" if argument.name else ""
                text += ("," if text else "") + name + expression(argument.value)
            case s.Option():
                value = f":={expression(argument.value)}" if argument.value is not None else ""
                text += f"\\{argument.name}{value}"
            case s.Conditional():
                text += f"\\{argument.name}?{expression(argument.variable)}"
    return text


def expression(node: s.Expression | s.Whole) -> str:
    match node:
        case s.NumberLiteral():
            return node.text
        case s.StringLiteral():
            return string(node.value)
        case s.BoolLiteral():
            return "TRUE" if node.value else "FALSE"
        case s.NameRef():
            return node.name
        case s.Component():
            return f"{expression(node.value)}.{node.name}"
        case s.Element():
            return expression(node.value) + "{" + ",".join(map(expression, node.indices)) + "}"
        case s.Whole():
            return "*"
        case s.AggregateNode():
            return "[" + ",".join(expression(i) for i in node.items) + "]"
        case s.Group():
            return f"({expression(node.inner)})"
        case s.FunctionCall():
            return f"{node.name}({arguments(node.arguments)})"
        case s.Prefix():
            return (
                node.operator + (" " if node.operator == "NOT" else "") + expression(node.operand)
            )
        case s.Infix():
            blank = " " if node.operator.isalpha() else ""
            return f"{expression(node.left)}{blank}{node.operator}{blank}{expression(node.right)}"
        case s.Placeholder():
            return node.text


def string(value: str) -> str:
    """A literal of ASCII only: other characters of Latin-1 as two hex digits.

    Raises ValueError for a character that is not in Latin-1.
    """
    pieces = []
    for c in value:
        if c in '"\\':
            pieces.append(c * 2)
        elif " " <= c <= "~":
            pieces.append(c)
        elif ord(c) < 256:
            pieces.append(f"\\{ord(c):02X}")
        else:
            raise ValueError(f"{c!r} is not in Latin-1")
    return '"' + "".join(pieces) + '"'

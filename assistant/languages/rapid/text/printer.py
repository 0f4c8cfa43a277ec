"""The typed tree to text, in one canonical layout."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import moves_text, targets_text
from assistant.program.diagnostics import Refused
from assistant.program.text import LINE_ENDS, one_line

INDENT: Final = "    "
NEWLINE: Final = "\r\n"


def print_file(file: s.File, newline: str = NEWLINE) -> str:
    """The whole file."""
    return _glued(Printer(newline).file(file), newline)


def print_items(items: Iterable[s.Item], newline: str = "\n") -> str:
    """Declarations as text of their own, without a last line end."""
    return _glued(Printer(newline).items(tuple(items), ""), newline).strip("\r\n")


def print_statements(body: Iterable[s.StatementNode], newline: str = "\n") -> str:
    """Statements as text of their own, without a last line end."""
    return _glued(Printer(newline).body(tuple(body), ""), newline).strip("\r\n")


def print_handler(handler: s.Handler, newline: str = "\n") -> str:
    """An error handler as text of its own, without a last line end."""
    return _glued(Printer(newline).handler(handler, ""), newline).strip("\r\n")


def comment(node: s.CommentLine) -> str:
    """The comment; what may end a line in it becomes a blank."""
    text = one_line(node.text).strip()
    return f"! {text}" if text else "!"


_TRAILS: Final = "\0"
"""Begins a text that belongs on the line before it."""


def _glued(texts: Iterable[str], newline: str) -> str:
    out = ""
    lines: list[str] = []
    for text in texts:
        if not text.startswith(_TRAILS):
            lines.append(out)
            out = text
        elif out:
            out = f"{out.removesuffix(newline)} {text[1:]}"
        else:
            out = text[1:]
    return "".join((*lines, out))


class Printer:
    """Lines of the canonical layout; `body` and `items` give what stands in a block."""

    def __init__(self, newline: str) -> None:
        self.newline = newline

    def line(self, indent: str, text: str) -> str:
        return indent + text + self.newline

    def file(self, file: s.File) -> Iterator[str]:
        if file.header is not None:
            yield f"%%%{file.header}%%%{self.newline}"
        for part in file.parts:
            if isinstance(part, s.Module):
                yield from self.module(part)
            else:
                yield self.comment(part, "")

    def module(self, module: s.Module) -> Iterator[str]:
        attributes = f"({','.join(module.attributes)})" if module.attributes else ""
        yield self.line("", f"MODULE {module.name}{attributes}")
        yield from self.items(module.items, INDENT)
        yield self.line("", "ENDMODULE")

    def items(self, items: tuple[s.Item, ...], indent: str) -> Iterator[str]:
        for at, item in enumerate(items):
            if isinstance(item, s.Routine) and at:
                yield self.newline
            yield from self.item(item, indent)

    def item(self, item: s.Item, indent: str) -> Iterator[str]:
        match item:
            case s.Routine():
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
            yield from self.handler(handler, indent)
        yield self.line(indent, f"END{r.kind}")

    def handler(self, handler: s.Handler, indent: str) -> Iterator[str]:
        numbers = ",".join(expression(n) for n in handler.numbers)
        yield self.line(indent, handler.kind + (f" ({numbers})" if numbers else ""))
        yield from self.body(handler.body, indent + INDENT)

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
        for node in body:
            yield from self.statement(node, indent)

    def comment(self, node: s.CommentLine, indent: str) -> str:
        return self.line(_TRAILS if node.trailing else indent, comment(node))

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
                yield self.line(indent, f"{node.name}:")
            case s.CommentLine():
                yield self.comment(node, indent)
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
    """A literal; other characters of Latin-1 than ASCII as two hex digits.

    What only UTF-8 can say, which RobotWare 7 reads, stays as it is; raises Refused for what would
    end the line.
    """
    pieces = []
    for c in value:
        if c in LINE_ENDS and ord(c) > 0xFF:
            what = f"a {LINE_ENDS[c]} in a text, which would end its line there"
            raise Refused(rules.NO_MEANING(what=what, hint="take it out"))
        if c in '"\\':
            pieces.append(c * 2)
        elif " " <= c <= "~" or ord(c) > 0xFF:
            pieces.append(c)
        else:
            pieces.append(f"\\{ord(c):02X}")
    return '"' + "".join(pieces) + '"'

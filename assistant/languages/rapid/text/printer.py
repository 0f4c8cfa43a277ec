"""The typed tree to text, in one canonical layout."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from assistant.base.diagnostics import Refused
from assistant.base.source_text import LINE_ENDS, one_line
from assistant.languages.rapid import rules
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import moves_text, targets_text
from assistant.languages.texts.printed_trees import Block, BlockPrinter, Templates, joined_texts

INDENT: Final = "    "
NEWLINE: Final = "\r\n"


def print_file(file: s.File, newline: str = NEWLINE) -> str:
    """The whole file."""
    header = "" if file.header is None else f"%%%{file.header}%%%{newline}"
    return header + PRINTER.text(file.parts, newline)


def print_nodes(nodes: Sequence[s.Item | s.StatementNode | s.Handler]) -> str:
    """Print declarations, statements or error handlers as separate text, without a final line
    end.
    """
    return PRINTER.text(nodes, "\n").strip("\n")


def comment(node: s.CommentLine) -> str:
    """The comment; what may end a line in it becomes a blank."""
    text = one_line(node.text).strip()
    return f"! {text}" if text else "!"


def expression(node: s.Expression | s.Whole) -> str:
    return TEMPLATES.text(node)


def string(value: str) -> str:
    """Return a string literal; Latin-1 characters beyond ASCII are written as two hex digits.

    Characters that only UTF-8 can express, which RobotWare 7 reads, remain unchanged; raises
    Refused for characters that would end the line.
    """
    pieces = []
    for c in value:
        # Characters up to 0xFF are written as hex digits and never end the line.
        if c in LINE_ENDS and ord(c) > 0xFF:
            what = f"a {LINE_ENDS[c]} in a text, which would end its line there"
            raise Refused(rules.NO_MEANING(what=what, cure="take it out"))
        if c in '"\\':
            pieces.append(c * 2)
        elif " " <= c <= "~" or ord(c) > 0xFF:
            pieces.append(c)
        else:
            pieces.append(f"\\{ord(c):02X}")
    return '"' + "".join(pieces) + '"'


# Declarations


def _record(_: Templates, node: s.Record) -> str:
    components = "".join(f"{INDENT}{type} {name};\n" for type, name in node.components)
    return f"{_local(node)}RECORD {node.name}\n{components}ENDRECORD"


def _data(to: Templates, node: s.Data) -> str:
    scope = f"{node.scope} " if node.scope else ""
    size = f"{{{to.text(node.dimensions)}}}" if node.dimensions else ""
    head = f"{scope}{node.storage} {node.type} {node.name}{size}"
    if node.value is None:
        return f"{head};"
    if not (node.dimensions and _is_long_list(node.value)):
        return f"{head}:={to.text(node.value)};"
    assert isinstance(node.value, s.AggregateNode)
    lines = ",\n".join(INDENT + to.text(item) for item in node.value.items)
    return f"{head}:=[\n{lines}];"


def _is_long_list(value: s.Expression) -> bool:
    """True for several records of records, such as targets, which people read one a line."""
    return (
        isinstance(value, s.AggregateNode)
        and len(value.items) > 1
        and all(
            isinstance(item, s.AggregateNode)
            and any(isinstance(part, s.AggregateNode) for part in item.items)
            for item in value.items
        )
    )


def _routine(to: Templates, node: s.Routine) -> list[str | Block]:
    type = f"{node.type} " if node.kind == "FUNC" else ""
    given = "" if node.kind == "TRAP" else f"({_parameters(to, node.parameters)})"
    head = f"{_local(node)}{node.kind} {type}{node.name}{given}\n"
    handlers = [part for handler in node.handlers for part in to.sketch(handler)]
    return [head, Block(node.body), *handlers, f"END{node.kind}"]


def _local(node: s.Record | s.Routine) -> str:
    return "LOCAL " if node.local else ""


def _parameters(to: Templates, groups: Sequence[s.ParameterGroup]) -> str:
    text = ""
    for group in groups:
        # RAPID writes no comma before an optional parameter.
        before = "\\" if group.optional else "," if text else ""
        text += before + "|".join(map(to.text, group.alternatives))
    return text


def _parameter(_: Templates, node: s.ParameterNode) -> str:
    array = "{<DIM>}" if node.dimensions < 0 else "{" + ",".join("*" * node.dimensions) + "}"
    mode = node.mode + " " if node.mode else ""
    return f"{mode}{node.type} {node.name}{array if node.dimensions else ''}"


# Statements


def _call(to: Templates, node: s.ProcedureCall) -> str:
    name = node.name if isinstance(node.name, str) else f"%{to.text(node.name)}%"
    given = _arguments(to, node.arguments)
    # An option follows the name without a blank, as in `WaitRob\InPos`.
    return name + (" " if given and not given.startswith("\\") else "") + given + ";"


def _arguments(to: Templates, given: Sequence[s.Argument]) -> str:
    text = ""
    for argument in given:
        text += "," if text and isinstance(argument, s.Positional) else ""
        text += to.text(argument)
    return text


def _if(to: Templates, node: s.IfThen) -> list[str | Block]:
    parts: list[str | Block] = []
    word = "IF"
    for branch in node.branches:
        if branch.condition is None:
            parts.append("<EIT>\n")
            continue
        parts += [f"{word} {to.text(branch.condition)} THEN\n", Block(branch.body)]
        word = "ELSEIF"
    if node.otherwise is not None:
        parts += ["ELSE\n", Block(node.otherwise)]
    return joined_texts([*parts, "ENDIF"])


def _case(to: Templates, node: s.TestCase) -> list[str | Block]:
    head = f"CASE {to.text(node.values)}:" if node.values else "<CSE>"
    return [head + "\n", Block(node.body)]


# Expressions


def _prefix(to: Templates, node: s.Prefix) -> str:
    return node.operator + (" " if node.operator == "NOT" else "") + to.text(node.operand)


def _infix(to: Templates, node: s.Infix) -> str:
    blank = " " if node.operator.isalpha() else ""
    return f"{to.text(node.left)}{blank}{node.operator}{blank}{to.text(node.right)}"


TEMPLATES: Final = Templates(
    {
        s.Module: "MODULE <name>[[(<attributes>)]]\n<items+>ENDMODULE",
        s.Record: _record,
        s.Alias: "<local:LOCAL >ALIAS <type> <name>;",
        s.Data: _data,
        s.Routine: _routine,
        s.Handler: "<kind>[[ (<numbers>)]]\n<body+>",
        s.ParameterNode: _parameter,
        s.CommentLine: lambda _, node: comment(node),
        s.Placeholder: "<text>",
        s.Assignment: "<target>:=<value>;",
        s.ProcedureCall: _call,
        s.GotoLabel: "GOTO <label>;",
        s.LabelMark: "<name>:",
        s.ReturnFrom: "RETURN[[ <value>]];",
        s.RaiseError: "RAISE[[ <value>]];",
        s.Word: "<word>;",
        s.Connect: "CONNECT <interrupt> WITH <trap>;",
        s.IfThen: _if,
        s.CompactIf: "IF <condition> <statement>",
        s.ForLoop: ("FOR <variable> FROM <first> TO <last>[[ STEP <step>]] DO\n<body+>ENDFOR"),
        s.WhileLoop: "WHILE <condition> DO\n<body+>ENDWHILE",
        s.TestOf: "TEST <subject>\n<cases*>[[DEFAULT:\n<otherwise+>]]ENDTEST",
        s.TestCase: _case,
        s.Positional: "[[<name>:=]]<value>",
        s.Option: "\\<name>[[:=<value>]]",
        s.Conditional: "\\<name>?<variable>",
        s.NumberLiteral: "<text>",
        s.StringLiteral: lambda _, node: string(node.value),
        s.BoolLiteral: lambda _, node: "TRUE" if node.value else "FALSE",
        s.NameRef: "<name>",
        s.Component: "<value>.<name>",
        s.Element: "<value>{<indices>}",
        s.Whole: "*",
        s.AggregateNode: "[<items>]",
        s.Group: "(<inner>)",
        s.FunctionCall: lambda to, node: f"{node.name}({_arguments(to, node.arguments)})",
        s.Prefix: _prefix,
        s.Infix: _infix,
    }
)
"""Text template of each construct."""


def _trails(node: Any) -> bool:
    return isinstance(node, s.CommentLine) and node.trailing


def _stands_apart(node: Any) -> bool:
    return isinstance(node, s.Routine)


PRINTER: Final = BlockPrinter(
    TEMPLATES,
    INDENT,
    tables={
        s.TargetRunNode: lambda node, indent, newline: targets_text(
            node.run, node.scope, indent, newline
        ),
        s.MoveRunNode: lambda node, indent, newline: moves_text(node.run, indent, newline),
    },
    trails=_trails,
    stands_apart=_stands_apart,
)
"""Printer for constructs on separate lines."""

"""Read-back proof: the written text, read again, is the same program as was written.

The files are read back from their bytes, parsed with the grammar by lark, and compared with the
pseudo-program.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from assistant.base.budgets import COMPARING, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule, Severity, error, has_errors
from assistant.languages.lark_parsing import Parsed, Spacing, parse
from assistant.program.comparison import Comparison, Tolerance, compare
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.robots import Robot


_NOT_READ_BACK = error(
    "CO101",
    "the text that was emitted cannot be read back: {reason}",
    "nothing was written; report this with the input",
)
READ_BACK_DIFFERS = error(
    "CO102",
    "the text that was emitted says something else: {message}",
    "nothing was written; report this with the input",
)

_REFUSED_THERE = error(
    "CO103",
    "a controller would refuse the program: {reason}",
    "correct the source ({cure}); nothing was written",
)

NOT_IN_GRAMMAR = error(
    "CO108",
    "the text that was emitted does not follow the grammar of {language}: {reason}",
    "nothing was written; report this with the input",
)


@dataclass(frozen=True, slots=True)
class Proof:
    """Result of comparing a program with its text, and the findings if it does not hold.

    read: program of the text that was read back, or what reads it once more if the proof did not
    keep it; None if it could not be read. grammar: lines that lark parsed, None if the language has
    no grammar for complete texts.
    """

    comparison: Comparison | None
    findings: tuple[Diagnostic, ...] = ()
    read: Program | Callable[[], Program] | None = None
    grammar: Parsed | None = None

    @property
    def lifted(self) -> Program | None:
        """The program of the text that was read back, None if it could not be read."""
        return self.read() if callable(self.read) else self.read

    def record(self) -> dict[str, Any] | None:
        """The numbers as plain data; None if nothing was compared."""
        c = self.comparison
        if c is None:
            return None
        return {
            "holds": self.holds,
            "statements": c.statements,
            "targets": c.targets,
            "position_mm": c.position,
            "angle_deg": c.angle,
            "grammar": None if self.grammar is None else self.grammar.record(),
        }

    @property
    def holds(self) -> bool:
        return self.comparison is not None and not has_errors(self.findings)

    def line(self) -> str:
        """The result in one line for people."""
        if self.comparison is None or not self.holds:
            return "not proven"
        c = self.comparison
        parsed = "" if self.grammar is None else f"; grammar: {self.grammar}"
        return (
            f"proven: {c.statements:,} statements and {c.targets:,} targets read back, "
            f"largest deviation {c.position:.6f} mm, {c.angle:.6f} degrees{parsed}"
        )


def prove_read_back(
    language: Language[Any],
    program: Program,
    files: Mapping[str, bytes],
    robot: Robot | None = None,
    compared: Callable[[Sequence[Any]], tuple[Program, Program]] | None = None,
    reduced: Callable[[Program], Program] | None = None,
    *,
    beside: Sequence[Any] = (),
    spacing: Spacing | None = None,
) -> Proof:
    """Reads the files back from their bytes, parses them with lark, and compares them.

    program: as the language adapted it. compared: returns it and the program of the trees in one
    spelling, where that is more than what lifting them gives. reduced: returns the part of either
    program that is compared, None to compare all. beside: trees that were parsed before, which the
    files are checked and lifted with. spacing: of the samples for lark, if the files are a part of
    a program. The findings of a proof that does not hold name the place in the program.
    """
    trees = [language.parse(language.decode(data, name)) for name, data in files.items()]
    findings = [finding for tree in trees for finding in tree.findings]
    if has_errors(findings):
        return Proof(None, (*_refusal_reasons(_NOT_READ_BACK, findings), *findings))
    parsed = parse(language, trees, NOT_IN_GRAMMAR, language.sampling, spacing)
    if parsed is not None and parsed.refused:
        return Proof(None, parsed.refused, grammar=parsed)
    trees += beside
    findings += language.check(trees)
    try:
        lifted = language.lift(trees, robot)
        if has_errors(findings):
            return Proof(
                None, (*_refusal_reasons(_REFUSED_THERE, findings), *findings), lifted, parsed
            )
        expected, actual = compared(trees) if compared else (program, lifted)
    except Refused as refused:
        reasons = [
            _NOT_READ_BACK(reason=f.message, about=f.about, missed=f.missing)
            for f in refused.findings
        ]
        return Proof(None, tuple(reasons), grammar=parsed)
    if reduced is not None:
        expected, actual = reduced(expected), reduced(actual)
    precision = language.precision
    tolerance = Tolerance(precision.position, precision.angle, precision.number)
    with within(COMPARING, None, expected.size()):
        comparison = compare(expected, actual, tolerance)
    otherwise = [
        READ_BACK_DIFFERS(message=m.message, about=m.about, span=None if compared else m.span)
        for m in comparison.mismatches
    ]
    return Proof(comparison, (*otherwise, *findings), lifted, parsed)


def _refusal_reasons(rule: Rule, findings: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Why nothing is written, for each error in the text that was emitted."""
    return [
        rule(
            path=f.path,
            span=f.span,
            line=f.line,
            column=f.column,
            reason=f.message,
            cure=f.cure,
            about=f.about,
            missed=f.missing,
        )
        for f in findings
        if f.severity is Severity.ERROR
    ]

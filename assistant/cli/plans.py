"""Plans and what became of them: for people, and for pull requests (Markdown)."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic
from assistant.cli.presentation import say
from assistant.report.markdown import cell, code, findings_markdown, folded, plain

if TYPE_CHECKING:
    from assistant.deploy import Deployment, Plan, PlannedFile

NOTHING_CHANGED: Final = "nothing has been changed"


def print_plan(plan: Plan) -> None:
    for file in plan.files:
        say(f"{file.name}: {file.change}" + (f" ({file.reason})" if file.reason else ""))
        for text in _what_differs(file).values():
            sys.stdout.write(text)
    for word, names in (("foreign", plan.foreign), ("left", plan.left)):
        if names:
            say(f"{word}: {', '.join(names)}")
    say(f"{plan.address}: {NOTHING_CHANGED}")


def plan_markdown(
    name: str, plan: Plan, done: Deployment | None, findings: Sequence[Diagnostic]
) -> str:
    """A comment. What a controller or a program says stands in code, which it cannot leave."""
    lines = [f"### {code(name)} ({code(str(plan.address))})", ""]
    lines += [
        "| program | change |" + (" state |" if done else ""),
        "|---|---|" + "---|" * bool(done),
    ]
    for file in plan.files:
        change = f"**{file.change}**" if file.reason else str(file.change)
        state = f" {done.states[file.name]} |" if done else ""
        lines.append(f"| {cell(file.name)} | {change} |{state}")
    lines += [f"| {cell(one)} | left |{' |' * bool(done)}" for one in plan.left]
    if plan.foreign:
        lines += ["", f"Foreign, never touched: {', '.join(map(code, plan.foreign))}"]
    for file in plan.files:
        for title, text in _what_differs(file).items():
            lines += ["", *folded(f"{plain(file.name)}: {title}", text)]
    if findings:
        lines.append("")
        lines += findings_markdown(findings)
    lines += ["", code(done.summary) if done else f"{NOTHING_CHANGED.capitalize()}."]
    return "\n".join(lines)


def _what_differs(file: PlannedFile) -> dict[str, str]:
    """What differs, by what it tells; the taught points are told only once."""
    found = {
        "changed on the controller since the last deployment": file.since,
        "otherwise in memory than in the file": "" if file.since else file.taught,
        "what would be sent": file.diff,
    }
    return {title: text for title, text in found.items() if text}

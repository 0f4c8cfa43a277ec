"""What cannot be said once parameters and results of procedures are variables of the program."""

from __future__ import annotations

from collections.abc import Mapping

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called_by, read_before
from assistant.program.effects import unknown_effect
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import Procedure, walk
from assistant.program.rewriting import Body, head, records


def refuse_kept_texts(job: Legalisation, procedure: Procedure) -> None:
    """An error for each kept text that names a parameter: it would name another variable then."""
    own = {parameter.name.lower(): parameter.name for parameter in procedure.parameters}
    for node in walk(procedure.body):
        for part in records(head(node)) if own else ():
            if isinstance(part, p.Opaque | e.Verbatim):
                effect = unknown_effect(part.text) if part.effect is None else part.effect
                for name in sorted(effect.names & own.keys()):
                    what = f"`{part.text}`, which names the parameter `{own[name]}`"
                    with job.findings.at(node.span):
                        job.cannot(what, "say it in plain statements")


def refuse_other_order(
    job: Legalisation,
    body: Body,
    called: Mapping[str, Procedure],
    alters: Mapping[str, frozenset[str]],
) -> None:
    """An error at each statement that would say another thing with its calls in front of it.

    called: procedures with parameters or a result. alters: what each procedure changes beyond its
    own variables. Names are in lower case.
    """
    for node in walk(body):
        if isinstance(node, p.WaitUntil) and node.timeout is not None:
            _refuse_once(job, node, called)
        alone = [b.condition for b in node.branches] if isinstance(node, p.If) else [head(node)]
        read = [pair for x in alone for pair in read_before(x, called, alters)]
        with job.findings.at(node.span):
            for name, function in dict.fromkeys(read):
                job.cannot(
                    what=f"that {called_by(name)} is read before `{function}` changes it",
                    cure="assign it to a variable in a statement before, and read that",
                )


def _refuse_once(job: Legalisation, node: p.WaitUntil, called: Mapping[str, Procedure]) -> None:
    """An error at a wait with a limit for what a call tells: it would be called once only."""
    for record in records(node.condition):
        if isinstance(record, e.Apply) and record.function.lower() in called:
            with job.findings.at(node.span):
                job.cannot(
                    what=f"a wait with a limit that calls `{record.function}` again and again",
                    cure="call it in a loop that waits a little and reads a clock",
                )

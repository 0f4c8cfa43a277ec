"""Settling: what is left of findings after ignoring comments and a project's severities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath

from assistant.compiler.checking import Text
from assistant.findings.severity import Severities, adjusted, severities_for
from assistant.findings.suppression import Sifted, sift
from assistant.program.diagnostics import Diagnostic


def apply_severities(
    findings: Sequence[Diagnostic], texts: Mapping[str, Text] | None = None
) -> Sifted:
    """The findings as the project wants them, in their order, and the ignored ones.

    texts: of the checked programs by path. Raises Unreadable or Refused for broken settings.
    """
    by_path: dict[str, list[Diagnostic]] = {path: [] for path in texts or ()}
    for finding in findings:
        by_path.setdefault(finding.path or "", []).append(finding)
    wanted: dict[FilePath, Severities] = {}
    left: list[Diagnostic] = []
    ignored: list[Diagnostic] = []
    for path, found in by_path.items():
        text = (texts or {}).get(path)
        sifted = Sifted(tuple(found))
        if text is not None:
            sifted = sift(found, text.source, text.mark, complete=text.complete)
        folder = FilePath(path).absolute().parent
        if folder not in wanted:
            wanted[folder] = severities_for(folder)
        left += adjusted(sifted.left, wanted[folder])
        ignored += adjusted(sifted.ignored, wanted[folder])
    odd = dict.fromkeys(f for severities in wanted.values() for f in severities.findings)
    return Sifted((*odd, *left), tuple(ignored))

"""Writing programs that may have been edited since they were written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from assistant.base.diagnostics import Diagnostic
from assistant.base.file_sets import write_all
from assistant.cli.answering import Files, files_by_path

if TYPE_CHECKING:
    from assistant.compiler.merge_edits import Keeper


@dataclass(slots=True)
class WrittenFiles:
    """written: files, in order. findings: about edits. diffs: by file, of what was edited.

    refused: sources of which nothing is written.
    """

    written: list[str] = field(default_factory=list)
    findings: list[Diagnostic] = field(default_factory=list)
    diffs: dict[str, str] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)


def write_with_edits(
    files: Mapping[str, Files], folders: Mapping[str, str], output: str, keeper: Keeper
) -> WrittenFiles:
    """Writes the files of all sources, with what was edited in those that are there."""
    from assistant.compiler.merge_edits import Kept, replaced, with_sources, written_in

    done = WrittenFiles()
    wanted: dict[Path, bytes] = {}
    compiled: dict[Path, bytes] = {}
    made: dict[Path, dict[str | Path, list[str]]] = {}
    for source in sorted(files, key=lambda source: source in folders):
        memory = written_in(Path(output) / folders.get(source, ""))
        wished = files_by_path(source, files[source], folders, output)
        others = [] if keeper.wishes.overwrite else replaced(wished, source, memory)
        kept = Kept({}, {}, findings=tuple(others)) if others else keeper.kept(wished, memory)
        done.findings += kept.findings
        if not kept.ok:
            done.refused.append(source)
            continue
        done.diffs |= {str(path): diff for path, diff in kept.diffs.items()}
        wanted |= kept.files
        compiled |= kept.compiled
        made.setdefault(memory, {})[source] = [path.name for path in wished]
    unknown = keeper.unknown_names()
    done.findings += unknown
    if wanted and not unknown:
        for memory, sources in made.items():
            compiled |= with_sources(sources, memory)
        write_all({**wanted, **compiled})
        done.written = [str(path) for path in wanted]
    return done

"""The files that are to be deployed: which they are, their names there, and what is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.source_text import folders_of, read_bytes
from assistant.controllers import Programs
from assistant.deploy import rules
from assistant.languages import Language, Tree


def gathered(paths: Sequence[str | FilePath], controller: Programs) -> list[str]:
    """The files that are meant: of a folder every program that the controller takes, and the
    modules that a list of them names, from beside it.

    Hidden folders are left aside. Raises Refused and Unreadable.
    """
    spoken = [languages.get(name) for name in controller.languages]
    files: list[str] = []
    for path in map(str, paths):
        if not FilePath(path).is_dir():
            files.append(path)
            continue
        inside = [str(file) for file in _inside(path) if _is_program(file, spoken, controller)]
        if not inside:
            raise Refused(rules.EMPTY_FOLDER(path=path), exit_status=2)
        files += inside
    for path in [file for file in files if file.lower().endswith(controller.lists)]:
        files += _listed_files(path, spoken[0])
    places = {FilePath(file).absolute(): file for file in reversed(files)}
    return [file for file in dict.fromkeys(files) if places[FilePath(file).absolute()] == file]


def _inside(folder: str) -> Iterator[FilePath]:
    found: list[FilePath] = []
    for inside, inner, names in folders_of(folder):
        inner[:] = [name for name in inner if not name.startswith(".")]
        found += [FilePath(inside, name) for name in names if not name.startswith(".")]
    yield from (file for file in sorted(found) if file.is_file())


def _is_program(file: FilePath, spoken: Sequence[Language[Any]], controller: Programs) -> bool:
    suffix = file.suffix.lower()
    if suffix in controller.lists:
        return True
    if not any(suffix in language.suffixes for language in spoken):
        return False
    return _file_languages(str(file), read_bytes(file, allow_empty=True), spoken) is not None


def _file_languages(
    path: str, data: bytes, spoken: Sequence[Language[Any]]
) -> Language[Any] | None:
    """Which of a controller's languages a file is in, or may be in as it is of an older version."""
    suffix = FilePath(path).suffix.lower()
    taking = [language for language in spoken if suffix in language.suffixes]
    found = next((one for one in taking if one.recognises(data, suffix)), None)
    if found is None and taking and (other := languages.of_file(path, data)) is not None:
        found = next((one for one in taking if other.name in one.older), None)
    return found


def _listed_files(path: str, language: Language[Any]) -> Iterator[str]:
    """The files that a list names; only from its own folder."""
    folder = FilePath(path).parent
    tree = language.parse(language.read(path))
    for name in language.called_files(tree):
        if FilePath(name).name != name or "\\" in name or name in ("", ".", ".."):
            raise Refused(rules.NOT_BESIDE(path=path, name=name))
        named = folder / name
        if not named.is_file():
            raise Refused(rules.NOT_THERE(path=path, name=name))
        yield str(named)


def controller_names(paths: Sequence[str], controller: Programs) -> dict[str, str]:
    """Local file → its name on the controller; no two may be the same there."""
    names: dict[str, str] = {}
    owner: dict[str, str] = {}
    findings: list[Diagnostic] = []
    for path in paths:
        try:
            name = names[path] = controller.name_for(path)
        except Refused as refusal:
            findings += [finding.within(path) for finding in refusal.findings]
            continue
        first = owner.setdefault(name.lower(), path)
        if first != path:
            findings.append(rules.SAME_NAME(path=path, first=first, second=path, name=name))
    if findings:
        raise Refused(*findings)
    return names


def file_findings(
    data: dict[str, bytes], names: Mapping[str, str], controller: Programs
) -> dict[str, tuple[Diagnostic, ...]]:
    """The findings of each file: of its own language, or that it is not the controller's.

    names: of the files on the controller, which may see other lines in them than we do. The
    language's rules see all files together, as the controller will.
    """
    notes: dict[str, tuple[Diagnostic, ...]] = {}
    trees: dict[str, dict[str, Tree]] = {}
    for path in data:
        name = _language(path, data[path], controller)
        if isinstance(name, Diagnostic):
            notes[path] = (name,)
        elif name is not None:
            language = languages.get(name)
            tree = language.parse(language.decode(data[path], path))
            trees.setdefault(name, {})[path] = tree
            notes[path] = tuple(finding.within(path) for finding in tree.findings)
    for name, files in trees.items():
        if not any(has_errors(notes[path]) for path in files):
            first = next(iter(files))
            for finding in languages.get(name).check(list(files.values())):
                path = finding.path if finding.path in files else first
                notes[path] = (*notes[path], finding)
    for path in data:
        if not has_errors(notes.get(path, ())):
            try:
                controller.check_text(names[path], data[path])
            except Refused as refused:
                unsent = (replace(finding, path=path) for finding in refused.findings)
                notes[path] = (*notes.get(path, ()), *unsent)
    return {path: tuple(dict.fromkeys(notes.get(path, ()))) for path in data}


def _language(path: str, data: bytes, controller: Programs) -> str | Diagnostic | None:
    """Name of the controller's language that a file is in, None for a list of modules."""
    if path.lower().endswith(controller.lists):
        return None
    language = _file_languages(path, data, [languages.get(name) for name in controller.languages])
    if language is not None:
        return language.name
    taken = ", ".join(languages.get(name).title for name in controller.languages)
    address, other = controller.address, languages.of_file(path, data)
    if other is None:
        return rules.UNKNOWN_LANGUAGE(path=path, address=address, taken=taken)
    return rules.WRONG_LANGUAGE(path=path, address=address, taken=taken, given=other.title)

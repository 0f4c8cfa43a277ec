"""Data that a module names and the controller has: what its heading says that they are.

    ! elsewhere: PERS tooldata gripper:=[TRUE,[[0,0,60],[1,0,0,0]],[0.5,[0,0,30],[1,0,0,0],0,0,0]]

So the module by itself can be checked, and moved through, with the values that it was made for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from assistant.base.diagnostics import Refused
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.text.header import module_header
from assistant.languages.rapid.text.printer import print_file
from assistant.languages.rapid.tree import syntax as s
from assistant.program.program import identifier


def header_declaration(data: s.Data) -> str:
    """A declaration as a heading says it: on one line, without its semicolon."""
    printed = print_file(s.File((s.Module("m", (), (data,)),)), "\n")
    return printed.split("\n")[1].strip().removesuffix(";")


def controller_data(module: s.Module) -> Iterator[s.Data]:
    """What the heading of a module says of data that the controller has."""
    for text in module_header(module).there:
        try:
            yield from (one for one in verbatim.items(text + ";") if isinstance(one, s.Data))
        except Refused:
            continue


def with_controller_data(files: Sequence[s.File]) -> Sequence[s.File]:
    """The files, with one beside them that declares what their headings state and none declares."""
    modules = [module for file in files for module in file.modules]
    found = {one.name.lower(): one for module in modules for one in controller_data(module)}
    if not found:
        return files
    for module in modules:
        for item in module.items:
            if isinstance(item, s.Data) and item.scope != "LOCAL":
                found.pop(item.name.lower(), None)
    if not found:
        return files
    name = identifier("elsewhere", {module.name for module in modules})
    return [*files, s.File((s.Module(name, (), tuple(found.values())),))]

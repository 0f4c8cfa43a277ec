"""A project: what `assistant.toml` says of programs and targets, built, checked and opened.

for target in targets_of(folder):
    with target.opened() as controller:
        plan = deploy.plan(target.files(), controller, task=target.task, load=target.load)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.project.building import Build, Built, State, build
    from assistant.project.layout import Place, Project, Recipe, project_of
    from assistant.project.target import Target, targets_of

_LAZY: Final = {
    "Build": ("assistant.project.building", "Build"),
    "Built": ("assistant.project.building", "Built"),
    "Place": ("assistant.project.layout", "Place"),
    "Project": ("assistant.project.layout", "Project"),
    "Recipe": ("assistant.project.layout", "Recipe"),
    "State": ("assistant.project.building", "State"),
    "Target": ("assistant.project.target", "Target"),
    "build": ("assistant.project.building", "build"),
    "project_of": ("assistant.project.layout", "project_of"),
    "targets_of": ("assistant.project.target", "targets_of"),
}

__all__ = [
    "Build",
    "Built",
    "Place",
    "Project",
    "Recipe",
    "State",
    "Target",
    "build",
    "project_of",
    "targets_of",
]

__getattr__ = offered(__name__, _LAZY)

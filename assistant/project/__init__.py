"""A project: what `assistant.toml` says of programs and targets, built, checked and opened.

for target in targets_of(folder):
    with target.opened() as controller:
        plan = deploy.plan(target.files(), controller, task=target.task, load=target.load)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.project.builds import Build, Built, State, build
    from assistant.project.deployment import Target, targets_of
    from assistant.project.project_file import Place, Project, Recipe, project_of

_LAZY: Final = {
    "Build": ("assistant.project.builds", "Build"),
    "Built": ("assistant.project.builds", "Built"),
    "Place": ("assistant.project.project_file", "Place"),
    "Project": ("assistant.project.project_file", "Project"),
    "Recipe": ("assistant.project.project_file", "Recipe"),
    "State": ("assistant.project.builds", "State"),
    "Target": ("assistant.project.deployment", "Target"),
    "build": ("assistant.project.builds", "build"),
    "project_of": ("assistant.project.project_file", "project_of"),
    "targets_of": ("assistant.project.deployment", "targets_of"),
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

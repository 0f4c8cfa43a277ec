"""Opening: the pseudo-program of a path, be it a file or a folder that holds one program."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant import sources
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.base.source_text import is_folder, path_of
from assistant.compiler import loading
from assistant.compiler.folders import programs_in
from assistant.compiler.loading import Loaded
from assistant.compiler.tasks import Task, load_task, tasks_of
from assistant.sources.placements import check_drawn

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.sources.placements import DrawingPlacement
    from assistant.sources.surroundings import SurroundingsByRobot

SEVERAL_PROGRAMS: Final = error(
    "CO047",
    "the folder `{name}` holds {count} programs",
    "name one of them: {names}",
)
MOST_TASKS_NAMED: Final = 8


def load(
    path: str | FilePath,
    *,
    process: str | FilePath | None = None,
    robot: Robot | None = None,
    language: str | None = None,
    unit: str | None = None,
    around: SurroundingsByRobot | None = None,
    placement: DrawingPlacement | None = None,
) -> Loaded:
    """The pseudo-program of a file, see `loading.load`, or of a folder with one robot program.

    A folder may be a controller's backup or a project; of several programs with one that begins
    by itself that is the one, the others being what nothing uses. Raises Unreadable or Refused.
    """
    path_of(path)
    if not is_folder(path) or FilePath(path).suffix.lower() in sources.READERS:
        return loading.load(
            path,
            process=process,
            robot=robot,
            language=language,
            unit=unit,
            around=around,
            placement=placement,
        )
    if placement is not None:
        check_drawn(FilePath(path))
    left = list[Diagnostic]()
    tasks = tasks_of(list(programs_in(str(path), language, left.append)), language)
    task = _only_task(tasks)
    if task is None:
        shown = ", ".join(f"`{one.name}`" for one in tasks[:MOST_TASKS_NAMED])
        names = (
            f"{shown} and {len(tasks) - MOST_TASKS_NAMED} more"
            if len(tasks) > MOST_TASKS_NAMED
            else shown
        )
        raise Refused(
            SEVERAL_PROGRAMS(name=path, count=len(tasks), names=names, path=str(path)),
            exit_status=2,
        )
    if len(task.files) > 1:
        loaded = load_task(task, process=process, robot=robot)
    else:
        file = task.files[0]
        loaded = loading.load(file, process=process, robot=robot, language=language, unit=unit)
    return replace(loaded, findings=(*left, *loaded.findings))


def _only_task(tasks: tuple[Task, ...]) -> Task | None:
    begun = [task for task in tasks if task.begins]
    return tasks[0] if len(tasks) == 1 else begun[0] if len(begun) == 1 else None

"""The commands that install programs, look at what was installed, and take it back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.on_controllers import complete_controller
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format, PlanFormat, answer_as

FilesArgument = Annotated[
    list[Path] | None,
    typer.Argument(help="Robot programs, or folders with them; default what the project deploys."),
]
ToOption = Annotated[
    str | None,
    typer.Option(
        "--to",
        metavar="CONTROLLER",
        help="Its name in assistant.toml, or its address.",
        autocompletion=complete_controller,
    ),
]
TargetOption = Annotated[
    list[str] | None,
    typer.Option("--target", help="Target of the project; repeatable, default all there are."),
]
HistoryOption = Annotated[
    Path | None,
    typer.Option(help="Folder of the deployments; default .robot-assistant/deployments."),
]
TaskOption = Annotated[str, typer.Option(help="Task whose memory counts; default the first.")]
LoadOption = Annotated[
    bool, typer.Option("--load", help="Also load modules that are not loaded yet.")
]
ReplaceOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME",
        help="Program to replace although no deployment left it as it is; * for all.",
    ),
]
PlanFormatOption = Annotated[
    PlanFormat,
    typer.Option("--format", help="For people, programs or pull requests.", callback=answer_as),
]


def plan(
    files: FilesArgument = None,
    to: ToOption = None,
    target: TargetOption = None,
    task: TaskOption = "",
    load: LoadOption = False,
    replace: ReplaceOption = None,
    history: HistoryOption = None,
    format: PlanFormatOption = PlanFormat.TEXT,
) -> None:
    """Show what a deployment would do to each program on a controller. Changes nothing."""
    from assistant.cli.deploying import run_plan
    from assistant.cli.jobs import DeploymentOptions

    wishes = DeploymentOptions(task, load, tuple(replace or ()), False, history)
    raise typer.Exit(run_plan(files or (), to, target or (), wishes, format))


def deploy(
    files: FilesArgument = None,
    to: ToOption = None,
    target: TargetOption = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only show what would change, as `plan` does.")
    ] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Finish the deployment that was interrupted.")
    ] = False,
    pull: Annotated[
        bool,
        typer.Option(
            "--pull",
            help="Deploy nothing; bring what was changed on the controller into the sources here.",
        ),
    ] = False,
    source: Annotated[
        Path | None,
        typer.Option(help="With --pull: what the program was compiled from; default itself."),
    ] = None,
    replace: ReplaceOption = None,
    files_only: Annotated[
        bool,
        typer.Option(
            "--files-only", help="Replace files though what was taught in memory is not seen."
        ),
    ] = False,
    task: TaskOption = "",
    load: LoadOption = False,
    canary: Annotated[
        str, typer.Option(metavar="TARGET", help="Goes first, alone; default as the project says.")
    ] = "",
    parallel: Annotated[
        int | None, typer.Option(min=1, help="Controllers at a time; default 4.")
    ] = None,
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE.xml", help="Write a JUnit report as well.")
    ] = None,
    history: HistoryOption = None,
    format: PlanFormatOption = PlanFormat.TEXT,
) -> None:
    """Install programs on a controller, read them back and compare. Never starts motion."""
    from assistant.cli.deployed import run_resume
    from assistant.cli.deploying import run_deploy, run_plan
    from assistant.cli.jobs import DeploymentOptions
    from assistant.cli.many_cells import RolloutOptions
    from assistant.cli.pulling import run_pull

    wishes = DeploymentOptions(task, load, tuple(replace or ()), files_only, history)
    if resume:
        raise typer.Exit(run_resume(files or (), to, target or (), wishes, format))
    if pull:
        raise typer.Exit(run_pull(files or (), to, target or (), source, wishes, format))
    if dry_run:
        raise typer.Exit(run_plan(files or (), to, target or (), wishes, format))
    manner = RolloutOptions(canary, parallel, junit) if canary or parallel or junit else None
    raise typer.Exit(run_deploy(files or (), to, target or (), wishes, manner, format))


def rollback(
    number: Annotated[
        int | None,
        typer.Argument(
            min=1, metavar="[N]", help="Deployment to take back with all after it; default the last"
        ),
    ] = None,
    to: ToOption = None,
    target: TargetOption = None,
    replace: ReplaceOption = None,
    history: HistoryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Take a deployment back: every program of it is again what it was before."""
    from assistant.cli.deployed import run_rollback

    raise typer.Exit(run_rollback(number, to, target or (), tuple(replace or ()), history, format))


def deployments(
    to: ToOption = None,
    history: HistoryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """List the deployments that this computer made: when, who, of which commit, what became."""
    from assistant.cli.deployed import run_deployments

    raise typer.Exit(run_deployments(to, history, format))


def verify(
    files: Annotated[
        list[Path] | None,
        typer.Argument(help="Robot programs, or folders with them, to compare as well."),
    ] = None,
    to: ToOption = None,
    target: TargetOption = None,
    history: HistoryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell whether a controller still has what the last deployment left there. Changes nothing."""
    from assistant.cli.deployed import run_verify

    raise typer.Exit(run_verify(files or (), to, target or (), history, format))

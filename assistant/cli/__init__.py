"""The command line: arguments in, presentation out."""

from __future__ import annotations


def main(arguments: list[str] | None = None) -> None:
    """Run one command; exit 0 clean, 1 with findings, 2 for wrong usage or unreadable input.

    A signal that ends the command is reported and exits with 130 for Ctrl-C, 143 for SIGTERM, 129
    for SIGHUP, unless the command was over by then, or is one that Ctrl-C ends normally.
    """
    if arguments is None:
        from assistant.cli.warm_client import hand_over

        hand_over()
    from assistant.cli.command_line import run

    run(arguments)

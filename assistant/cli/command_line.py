"""One command in a process: its signals, its exit status, and what it is refused for."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
from contextlib import suppress
from contextvars import copy_context
from typing import Final

from assistant.base.budgets import FACTOR_VARIABLE, Reached, internal_error, traceback_wanted
from assistant.base.diagnostics import Refused, error
from assistant.base.termination import (
    INTERRUPTED,
    ORDINARY_SIGNALS,
    SIGNAL_EXIT_STATUS,
    raise_on_termination,
)
from assistant.cli.warm_client import SERVER_VARIABLE, SETTINGS

NOT_PRINTED = error(
    "CL901",
    "the system refuses: {reason}",
    "make room, or name another place; what was printed may be cut off",
)

_NO_SETTING: Final = error(
    "CL903",
    "{variable} is `{value}`",
    "set it to `auto` or `off`, or leave it out",
)


def run(arguments: list[str] | None = None) -> None:
    """Run one command and exit with its status; see `assistant.cli.main`."""
    if arguments is None:
        settle_in()
    before = os.environ.get(FACTOR_VARIABLE)
    status: str | int | None = INTERRUPTED
    with suppress(KeyboardInterrupt), raise_on_termination(signals=ORDINARY_SIGNALS) as ending:
        try:
            # In a context of its own: what one command was asked for, the next one was not.
            copy_context().run(_run, arguments)
        except SystemExit as ended:
            status = ended.code
        finally:
            ending.hold()
            if before is None:
                os.environ.pop(FACTOR_VARIABLE, None)
            else:
                os.environ[FACTOR_VARIABLE] = before
    if ending.number is not None and status:
        status = SIGNAL_EXIT_STATUS + ending.number
        with suppress(OSError):  # the terminal may be what was closed
            sys.stderr.write(f"ended by {signal.Signals(ending.number).name}\n")
            sys.stderr.flush()
    sys.exit(status)


NEW_OBJECTS: Final = 100_000
"""After which the cycle collector looks for garbage; commands are short and make little."""


def settle_in() -> None:
    """Set up a process that runs a single command, so that it starts and ends faster."""
    gc.set_threshold(NEW_OBJECTS)
    atexit.register(_discard_leaks)  # what is registered first is called last
    atexit.register(gc.freeze)  # what ends with the process is not looked through before
    # Matrices of poses are small. Starting threads for large ones takes longer than all the rest.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _discard_leaks() -> None:
    """The planner's library tells its developers, behind all else, what it did not free."""
    if "ompl" in sys.modules:
        with suppress(OSError, ValueError):
            sys.stderr.flush()
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


def _run(arguments: list[str] | None) -> None:
    from assistant.base.file_sets import reporting_leftovers
    from assistant.cli.app import app, refuse_passwords
    from assistant.cli.presentation import print_findings, print_refused

    try:
        setting = os.environ.get(SERVER_VARIABLE)
        if setting and setting not in SETTINGS:
            refusal = _NO_SETTING(variable=SERVER_VARIABLE, value=setting)
            raise Refused(refusal, exit_status=2)
        refuse_passwords(sys.argv[1:] if arguments is None else arguments)
        with reporting_leftovers(lambda finding: print_findings([finding])):
            app(args=arguments, prog_name="robot-assistant")
    except Refused as refused:
        print_refused(refused.findings)
        sys.exit(refused.exit_status)
    except Reached as reached:  # between two stages
        print_refused([internal_error(reached)])
        sys.exit(2)
    except BrokenPipeError:
        _discard_output()  # the reader went away, as `head` does; its end is not our error
        sys.exit(0)
    except OSError as error:
        finding = NOT_PRINTED(reason=error.strerror or error)
        try:
            sys.stdout.flush()  # which fails where it was the output that was refused
            print_refused([finding])
            sys.stdout.flush()
        except OSError:
            print_findings([finding])
            _discard_output()
        sys.exit(2)
    except Exception as error:
        if traceback_wanted():
            raise
        print_refused([internal_error(error)])
        sys.exit(2)


def _discard_output() -> None:
    """Discard buffered output, which must not fail again when the interpreter ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

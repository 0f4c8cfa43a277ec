"""Processes that deploy, to be killed."""

import contextlib
import multiprocessing
import os
import sys

CHILDREN = multiprocessing.get_context("spawn" if os.name == "nt" else "forkserver")
CHILDREN.set_forkserver_preload(["assistant.cli.app", "assistant.deploy", "tests.deploy.children"])


@contextlib.contextmanager
def child(bench, most=None):
    """A process that runs `robot-assistant deploy` once the block is over, and has ended then.

    most: bytes of its files on this computer.
    """
    ready, go = CHILDREN.Pipe(duplex=False)
    process = CHILDREN.Process(
        target=_command, args=(ready, bench.arguments(), bench.password, most)
    )
    process.start()
    try:
        yield process
        go.send(True)
        process.join(60)
        assert process.exitcode is not None
    finally:
        process.kill()
        process.join()


def _command(ready, arguments, password, most):
    from assistant import cli

    ready.recv()
    if most is not None:
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    with open(os.devnull, "w", encoding="utf-8") as nowhere:  # noqa: PTH123
        sys.stdout = sys.stderr = nowhere
        sys.argv = ["robot-assistant", *arguments]
        os.environ["ROBOT_ASSISTANT_PASSWORD"] = password or ""
        cli.main()

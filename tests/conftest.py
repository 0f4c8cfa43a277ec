"""How hypothesis and signals work here, wherever the tests are started from.

A slow or busy machine is no fault of what is tested.

`make test` draws the same cases at each run and on each machine, so that a failure is of the
change that is tested. `make test-slow` draws new ones (`--hypothesis-profile=fresh`); what these
find becomes a case of its own.
"""

from __future__ import annotations

import faulthandler
import gc
import signal
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, TextIO

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture.providers import Constants, HypothesisProvider

from tests.forks import Forks

settings.register_profile(
    "fresh",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.register_profile(
    "same", settings.get_profile("fresh"), max_examples=20, derandomize=True, database=None
)
settings.load_profile("same")


@pytest.hookimpl(trylast=True)  # after pytest's own use of `faulthandler`
def pytest_configure(config: pytest.Config) -> None:
    """Keeps the constants in our own modules out of the draws that are the same everywhere, and has
    a worker that crashes write where.

    hypothesis collects them from the modules that are loaded, and which ones are depends on the
    tests that ran before in the same process.
    """
    if settings.default is not None and settings.default.derandomize:
        HypothesisProvider._local_constants = Constants()
    given = getattr(config, "workerinput", {})
    if CRASHES in given:
        config.stash[CRASH] = file = (Path(given[CRASHES]) / given["workerid"]).open("w")
        faulthandler.enable(file)


CRASHES: Final = "crashes"
CRASH: Final = pytest.StashKey[TextIO]()
"""The file that a worker writes into if it crashes, open as long as it runs."""


MOST: Final = 60
"""Lines of it that are shown."""


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tells a worker where to write if it crashes."""
    if not hasattr(node.config, CRASHES):
        node.config.crashes = TemporaryDirectory(prefix="crashes-")
        node.config.add_cleanup(node.config.crashes.cleanup)
    node.workerinput[CRASHES] = node.config.crashes.name


@pytest.hookimpl(optionalhook=True)
def pytest_handlecrashitem(report: pytest.TestReport) -> None:
    """Tells what ended a worker: the threads of a fault, or only the number of a signal."""
    node: Any = getattr(report, "node")  # noqa: B009 - set by xdist
    threads = (Path(node.workerinput[CRASHES]) / node.gateway.id).read_text("utf-8", "replace")
    own = [line for line in threads.splitlines() if "/_pytest/" not in line]
    status = node.gateway._io.popen.wait(60)
    report.longrepr = "\n".join((str(report.longrepr), f"it ended with {status}", *own[:MOST]))


# A job in the background of a script has Ctrl+C ignored, and so would have the servers that
# tests stop with it.
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):  # `nohup` has it ignored
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collects without looking for garbage: of the millions of objects none is any.

    Half of the time of each worker went into it. Nor are they looked through while tests run.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_unconfigure() -> None:
    """Lets Python end as it always does: some libraries name what it does not take apart."""
    gc.unfreeze()


SAMPLED: Final = pytest.StashKey[int]()
"""How many cases of sampled tests are left to `make test-slow`."""


@pytest.hookimpl(tryfirst=True)  # before pytest deselects what is slow
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Of the cases of a test that is marked `one_in(n)` every nth stays, the others are slow."""
    seen: Counter[str] = Counter()
    left = 0
    for item in items:
        mark = item.get_closest_marker("one_in")
        if mark is None:
            continue
        test = item.nodeid.partition("[")[0]
        if seen[test] % mark.args[0]:
            item.add_marker(pytest.mark.slow)
            left += 1
        seen[test] += 1
    config.stash[SAMPLED] = left


TOLD = "told"


@pytest.fixture
def tell(record_property: Callable[[str, object], None]) -> Callable[[str], None]:
    """Prints something below all tests, also where they run in several processes."""
    return lambda text: record_property(TOLD, text)


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, exitstatus: int, config: pytest.Config
) -> None:
    """Prints the counts of sweeps, and of the cases that are left out."""
    reports = (one for kind in ("passed", "failed") for one in terminalreporter.getreports(kind))
    said = [text for one in reports for name, text in one.user_properties if name == TOLD]
    for text in said:
        terminalreporter.write_line(str(text).strip())
    if left := config.stash.get(SAMPLED, 0):
        terminalreporter.write_line(f"{left} cases of sampled tests are left to `make test-slow`")


@pytest.fixture(scope="session")
def forks() -> Iterator[Forks]:
    with Forks() as running:
        yield running

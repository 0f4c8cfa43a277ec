"""How hypothesis and signals work here, wherever the tests are started from.

A slow or busy machine is no fault of what is tested.

`make test` draws the same cases at each run and on each machine, so that a failure is of the
change that is tested. `make test-slow` draws new ones (`--hypothesis-profile=fresh`); what these
find becomes a case of its own.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture.providers import Constants, HypothesisProvider

from tests.forks import Forks

settings.register_profile(
    "fresh",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.register_profile("same", settings.get_profile("fresh"), derandomize=True, database=None)
settings.load_profile("same")


def pytest_configure(config: pytest.Config) -> None:
    """Keeps the constants in our own modules out of the draws that are the same everywhere.

    hypothesis collects them from the modules that are loaded, and which ones are depends on the
    tests that ran before in the same process.
    """
    if settings.default is not None and settings.default.derandomize:
        HypothesisProvider._local_constants = Constants()


# A job in the background of a script has Ctrl+C ignored, and so would have the servers that
# tests stop with it.
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):  # `nohup` has it ignored
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


TOLD = "told"


@pytest.fixture
def tell(record_property: Callable[[str, object], None]) -> Callable[[str], None]:
    """Prints something below all tests, also where they run in several processes."""
    return lambda text: record_property(TOLD, text)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Counts of sweeps, which nobody would see else."""
    reports = (one for kind in ("passed", "failed") for one in terminalreporter.getreports(kind))
    said = [text for one in reports for name, text in one.user_properties if name == TOLD]
    for text in said:
        terminalreporter.write_line(str(text).strip())


@pytest.fixture(scope="session")
def forks() -> Iterator[Forks]:
    with Forks() as running:
        yield running

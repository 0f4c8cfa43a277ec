"""How hypothesis works here: a slow or busy machine is no fault of what is tested.

`make test` draws the same cases at each run and on each machine, so that a failure is of the
change that is tested. `make test-slow` draws new ones (`--hypothesis-profile=fresh`); what these
find becomes a case of its own.
"""

from __future__ import annotations

from hypothesis import HealthCheck, settings

settings.register_profile(
    "fresh",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.register_profile("same", settings.get_profile("fresh"), derandomize=True, database=None)
settings.load_profile("same")

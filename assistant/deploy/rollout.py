"""Rollout to many controllers: a canary first, some in parallel, and none begun after a failure.

cells = [Cell("cell1", client.address, lambda: plan(["out/seam.mod"], client)), …]
rollout = deploy_to_all(cells, canary="cell1", parallel=4)
"""

from __future__ import annotations

import enum
import time
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import Final

from assistant.base.budgets import internal_error, traceback_wanted
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import Address
from assistant.deploy import rules
from assistant.deploy.deployment import PUT_BACK_TIMEOUT, Deployment, Tell, deploy
from assistant.deploy.history import Entry
from assistant.deploy.plan import Plan

PARALLEL: Final = 4
"""Controllers that are deployed to at the same time."""
_DONE_POLL: Final = 0.2
"""Seconds between two looks whether all are done: a wait without end could not be interrupted on
every system."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A controller to deploy to.

    name: as the user calls it. plan: makes the plan. It is called in a thread, never in two at
    once for cells of one controller, which may share a session; for these it is called again once
    the one before is done.
    """

    name: str
    address: Address
    plan: Callable[[], Plan]


class CellState(enum.StrEnum):
    """Result of a cell."""

    DONE = "done"
    """Every program is there and verified."""
    FAILED = "failed"
    """It could not be planned, or the deployment to it failed; its states describe its programs."""
    NOT_BEGUN = "not begun"
    """Nothing was changed on it, because of another one or of an interruption."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """A cell after all.

    plan: None if it could not be made. deployment: None if none was begun. status: exit status
    that stands for it. seconds: that its deployment took.
    """

    name: str
    address: Address
    state: CellState
    plan: Plan | None = None
    deployment: Deployment | None = None
    findings: tuple[Diagnostic, ...] = ()
    status: int = 0
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class Rollout:
    """Results of all cells, in their order."""

    outcomes: tuple[Outcome, ...]

    @property
    def ok(self) -> bool:
        return all(one.state is CellState.DONE for one in self.outcomes)

    @property
    def status(self) -> int:
        return max((one.status for one in self.outcomes), default=0)

    @property
    def summary(self) -> str:
        """One sentence on all of them."""
        done = [one for one in self.outcomes if one.state is CellState.DONE]
        parts = [f"{len(done)} of {len(self.outcomes)} controllers are done"]
        for state in (CellState.FAILED, CellState.NOT_BEGUN):
            names = [one.name for one in self.outcomes if one.state is state]
            if names:
                parts.append(f"{state}: {', '.join(names)}")
        return "; ".join(parts)


@dataclass(slots=True)
class Halt:
    """Asked for by whoever wants an end in order, a handler of a signal for instance.

    No more cells are begun then. Those under way take back what they changed, as soon as the
    program is there that they were sending; one whose line is lost is left open. noticed: called
    once, in the thread that waits.
    """

    asked: bool = False
    noticed: Callable[[], None] = lambda: None


def deploy_to_all(
    cells: Sequence[Cell],
    *,
    canary: str = "",
    parallel: int = PARALLEL,
    history: str | FilePath | None = None,
    files_only: bool = False,
    patience: float = PUT_BACK_TIMEOUT,
    halt: Halt | None = None,
    tell: Tell | None = None,
) -> Rollout:
    """Plans all cells, and deploys to each if every one could be planned without a conflict.

    canary: name of the cell that goes first, alone. After a failure no more are begun; those
    under way go on to their end. Cells of one controller follow each other, in their order.
    Nothing is raised for a cell that fails. history, files_only, patience, tell: see `deploy`.
    Raises Refused, of exit status 2, if no cell has the name of the canary.
    """
    if canary and canary not in (cell.name for cell in cells):
        known = ", ".join(f"`{cell.name}`" for cell in cells)
        raise Refused(rules.NO_CANARY(name=canary, known=known), exit_status=2)
    options = _Options(history, files_only, patience, tell)
    return _Rollout(cells, parallel, options, halt or Halt()).done(canary)


@dataclass(frozen=True, slots=True)
class _Options:
    history: str | FilePath | None
    files_only: bool
    patience: float
    tell: Tell | None


@dataclass(slots=True)
class _Rollout:
    """Deployments under way. failed: the first cell that failed. outcomes: by index."""

    cells: Sequence[Cell]
    parallel: int
    options: _Options
    halt: Halt
    failed: str = ""
    outcomes: dict[int, Outcome] = field(default_factory=dict)

    def done(self, canary: str) -> Rollout:
        # Everything is planned before anything is deployed: a conflict anywhere begins nothing.
        self._each(self._plan, self._chains())
        planned = [self.outcomes[index] for index in range(len(self.cells))]
        first = next((one for one in planned if one.state is CellState.FAILED), None)
        self.failed = first.name if first else ""
        early = [i for i, cell in enumerate(self.cells) if cell.name == canary][:1]
        self._each(self._follow, [early])
        self._each(self._follow, self._chains(without=early))
        return Rollout(tuple(self.outcomes[i] for i in range(len(self.cells))))

    def _chains(self, without: Collection[int] = ()) -> list[list[int]]:
        """The cells of each controller: two deployments to one at once are refused."""
        chains: dict[str, list[int]] = {}
        for index, cell in enumerate(self.cells):
            if index not in without:
                chains.setdefault(cell.address.label, []).append(index)
        return list(chains.values())

    def _each(self, work: Callable[[list[int]], None], chains: Sequence[list[int]]) -> None:
        """Does work on all chains, some at once; whatever interrupts it is raised at the end."""
        with ThreadPoolExecutor(max_workers=max(1, self.parallel)) as pool:
            under_way = [pool.submit(work, chain) for chain in chains]
            _wait(under_way, self.halt)
        for one in under_way:
            one.result()

    def _plan(self, chain: Sequence[int]) -> None:
        for index in chain:
            self.outcomes[index] = self._planned(index)

    def _planned(self, index: int) -> Outcome:
        cell = self.cells[index]
        outcome = Outcome(cell.name, cell.address, CellState.NOT_BEGUN)
        if self.halt.asked:
            return outcome
        try:
            plan = cell.plan()
        except Exception as error:  # noqa: BLE001 - told as the finding of this cell
            return _failed(outcome, error)
        undecided = [rules.UNDECIDED(place=f.name, name=f.name) for f in plan.conflicts]
        outcome = replace(outcome, plan=plan)
        return _failed(outcome, Refused(*undecided)) if undecided else outcome

    def _follow(self, chain: Sequence[int]) -> None:
        """Deploys to the cells of one controller, one after another."""
        for index in chain:
            outcome = self.outcomes[index]
            if outcome.state is CellState.FAILED:
                continue
            if self.halt.asked or self.failed:
                self.outcomes[index] = self._not_begun(outcome)
                continue
            self.outcomes[index] = outcome = self._deployed(index)
            if outcome.state is CellState.FAILED:
                self.failed = self.failed or outcome.name

    def _deployed(self, index: int) -> Outcome:
        outcome, options = self.outcomes[index], self.options
        begun = time.monotonic()
        try:
            plan = outcome.plan
            # The plan of a chain's later cells is older than the deployments before them.
            if plan is None or self._is_changed(index):
                plan = self.cells[index].plan()
            outcome = replace(outcome, plan=plan)
            done = deploy(
                plan,
                history=options.history,
                files_only=options.files_only,
                patience=options.patience,
                progress=self._go_on,
                tell=options.tell,
                leave=lambda: self.halt.asked,
            )
        except Exception as error:  # noqa: BLE001 - told as the finding of this cell
            return replace(_failed(outcome, error), seconds=time.monotonic() - begun)
        return replace(
            outcome,
            state=CellState.DONE if done.ok else CellState.FAILED,
            deployment=done,
            findings=done.findings,
            status=0 if done.ok else 1,
            seconds=time.monotonic() - begun,
        )

    def _is_changed(self, index: int) -> bool:
        """True if the controller received a deployment since the plan was made."""
        label = self.cells[index].address.label
        return any(
            one.deployment is not None and one.address.label == label
            for one in list(self.outcomes.values())
        )

    def _go_on(self, entry: Entry) -> None:
        """Breaks a deployment off before its next program, which takes it back."""
        if self.halt.asked:
            raise KeyboardInterrupt(entry.name)

    def _not_begun(self, outcome: Outcome) -> Outcome:
        rule = rules.NOT_BEGUN if self.halt.asked else rules.NOT_BEGUN_AFTER
        place = str(outcome.address)
        finding = rule(place=place, name=outcome.name, failed=self.failed)
        return replace(outcome, findings=(finding,), status=1)


def _failed(outcome: Outcome, error: Exception) -> Outcome:
    if isinstance(error, Refused):
        findings, status = error.findings, error.exit_status
    elif traceback_wanted():
        raise error
    else:
        findings, status = (internal_error(error),), 2
    return replace(outcome, state=CellState.FAILED, findings=findings, status=status)


def _wait(under_way: Sequence[Future[None]], halt: Halt) -> None:
    """Until all are done; an interruption is an end in order for them, and is raised then."""
    interrupted: BaseException | None = None
    noticed = halt.asked
    while True:
        try:
            # A wait without end cannot be interrupted on every system.
            if not wait(under_way, timeout=_DONE_POLL).not_done:
                break
            if halt.asked and not noticed:
                noticed = True
                halt.noticed()
        except KeyboardInterrupt as caught:
            halt.asked, interrupted = True, caught
    if interrupted is not None:
        raise interrupted

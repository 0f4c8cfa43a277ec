"""Inputs and outputs of a controller, by name."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.answers import Row
from assistant.controllers.abb.rws.mastership import Mastership
from assistant.controllers.abb.rws.session import Session

SIGNAL_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
INPUTS: Final = frozenset({"DI", "AI", "GI"})
OUTPUTS: Final = frozenset({"DO", "AO", "GO"})
LARGEST_GROUP: Final = 2**32 - 1


class Signals:
    def __init__(self, session: Session, mastership: Mastership) -> None:
        self._session = session
        self._mastership = mastership
        self._places: dict[str, tuple[str, str]] = {}

    def values(self, names: Sequence[str], kinds: frozenset[str]) -> dict[str, float]:
        """What signals read; without names, of all signals of these kinds.

        A signal of another kind is told as well: its value is what it is.
        """
        if not names:
            return self._all(kinds)
        return {name: self._value(name) for name in names}

    def place(self, name: str) -> str:
        """Network, device and name of a signal, as its address has them."""
        return self._place(name)[0]

    def known(self, name: str) -> str:
        """The name, if there is such a signal."""
        self._place(name)
        return name

    def set(self, name: str, value: float) -> None:
        path, kind = self._place(name)
        if kind not in OUTPUTS:
            raise self._session.refusal(
                f"set `{name}`", f"it is no output but a {kind}", "name an output"
            )
        whole = math.isfinite(value) and value == int(value)
        good = {
            "DO": value in (0, 1),
            "GO": whole and 0 <= value <= LARGEST_GROUP,
            "AO": math.isfinite(value),
        }
        if not good[kind]:
            form = {"DO": "0 or 1", "GO": "a whole number from 0", "AO": "a number"}[kind]
            raise Refused(
                rules.BAD_VALUE(
                    place=name, value=f"{value:g}", what=f"the value of `{name}`",
                    reason=f"it is a {kind}", form=form,
                )
            )  # fmt: skip
        self._mastership.ask(
            "set signal",
            doing=f"setting `{name}`",
            state=f"`{name}` is as it was",
            form={"lvalue": str(int(value)) if whole else repr(value)},
            at={"path": path},
        )

    def _all(self, kinds: frozenset[str]) -> dict[str, float]:
        doing = "listing the signals"
        pages = self._session.pages("signals", doing=doing)
        rows = [row for page in pages for row in page.of("ios-signal")]
        wanted = [row for row in rows if row.get("type") in kinds]
        return {_checked_signal_name(row): self._number(row, doing) for row in wanted}

    def _value(self, name: str) -> float:
        doing = f"reading `{name}`"
        path, _ = self._place(name)
        rows = self._session.ask("signal", doing=doing, at={"path": path}).of("ios-signal")
        if not rows:
            raise self._session.garbled(doing, "there is no signal in it")
        return self._number(rows[0], doing)

    def _number(self, row: Row, doing: str) -> float:
        try:
            return float(row.get("lvalue"))
        except ValueError:
            raise self._session.garbled(doing, f"a value `{row.get('lvalue')}`") from None

    def _named(self, name: str) -> list[Row]:
        """Signals of a name; the controller looks for names that it is a part of."""
        doing = f"looking for the signal `{name}`"
        found = self._session.ask("find signal", doing=doing, form={"name": name})
        pages = [found]
        if found.next and not any(
            _checked_signal_name(r).lower() == name.lower() for r in found.rows
        ):
            pages = self._session.pages("signals", doing=doing)
        rows = [row for page in pages for row in page.of("ios-signal")]
        return [row for row in rows if _checked_signal_name(row).lower() == name.lower()]

    def _place(self, name: str) -> tuple[str, str]:
        """Address and type of a signal; looked for once, for they stay until a restart."""
        if not SIGNAL_NAME.fullmatch(name):
            reason = "a letter, then letters, digits and `_`, 32 at most"
            raise Refused(
                rules.BAD_VALUE(
                    place=name,
                    value=name,
                    what="the name of a signal",
                    reason=reason,
                    form="`doGripper`",
                )
            )
        if name not in self._places:
            same = self._named(name)
            if not same:
                raise self._session.refusal(
                    f"find the signal `{name}`", "there is none", "check its name"
                )
            self._places[name] = (
                same[0].title or _checked_signal_name(same[0]),
                same[0].get("type"),
            )
        return self._places[name]


def _checked_signal_name(row: Row) -> str:
    return row.get("name") or row.title.rpartition("/")[2]

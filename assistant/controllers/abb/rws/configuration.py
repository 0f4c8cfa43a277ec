"""System parameters: instances of the configuration database, by domain, type and name.

`EIO/EIO_SIGNAL/doGripper/Access` is an attribute of an instance; a shorter name is all below it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.answers import Answer, Row
from assistant.controllers.abb.rws.mastership import Mastership
from assistant.controllers.abb.rws.session import Session

PARAMETER_PART: Final = re.compile(r"[A-Za-z0-9_.\- ]+")
UNSAFE_IN_VALUE: Final = re.compile(r"[\x00-\x1f\x7f&%+\[\]\"]")
"""What would be another attribute, or the end of the value, in the form of RWS 2.0."""


class Configuration:
    def __init__(self, session: Session, mastership: Mastership) -> None:
        self._session = session
        self._mastership = mastership

    def values(self, names: Sequence[str]) -> dict[str, str]:
        """Attributes by `DOMAIN/TYPE/INSTANCE/ATTRIBUTE`, of names of two to four parts."""
        if not names:
            raise self._session.refusal(
                "tell which parameters have been changed",
                "it does not keep account of that",
                "name them, as in `EIO/EIO_SIGNAL`, or make a backup",
            )
        found: dict[str, str] = {}
        for name in names:
            parts = self._parts(name, 2)
            here = {
                full: value
                for full, value in self._of_type(parts[0], parts[1]).items()
                if full.lower().split("/")[: len(parts)] == [part.lower() for part in parts]
            }
            if not here:
                raise self._session.refusal(
                    f"tell `{name}`", "there is no such parameter", "check domain, type and name"
                )
            found.update(here)
        return found

    def set(self, name: str, value: str) -> None:
        """Sets an attribute; most take hold after the controller has been restarted."""
        domain, kind, instance, attribute = self._parts(name, 4)
        if UNSAFE_IN_VALUE.search(value):
            raise Refused(
                rules.BAD_VALUE(
                    place=name, value=value, what=f"the value of `{name}`",
                    reason="it holds a character that is not sent", form="text without `& % + [ ]`",
                )
            )  # fmt: skip
        if name.lower() not in {known.lower() for known in self.values((name,))}:
            raise self._session.refusal(f"set `{name}`", "there is none", "check its name")
        doing = f"setting `{name}`"
        written = f"[{value},1]" if self._session.dialect.secure else value
        self._mastership.ask(
            "set instance",
            doing=doing,
            state=f"`{name}` is as it was",
            form={attribute: written},
            at={"domain": domain, "type": kind, "instance": instance},
        )

    def _parts(self, name: str, least: int) -> list[str]:
        parts = name.split("/")
        if not least <= len(parts) <= 4 or not all(
            PARAMETER_PART.fullmatch(part) for part in parts
        ):
            raise Refused(
                rules.BAD_VALUE(
                    place=name, value=name, what="the name of a parameter",
                    reason="it is DOMAIN/TYPE/INSTANCE/ATTRIBUTE",
                    form="`EIO/EIO_SIGNAL/doGripper/Access`",
                )
            )  # fmt: skip
        return parts

    def _of_type(self, domain: str, kind: str) -> dict[str, str]:
        doing = f"reading the parameters `{domain}/{kind}`"
        pages = self._session.pages("instances", doing=doing, at={"domain": domain, "type": kind})
        return {
            f"{domain}/{kind}/{name}": value
            for page in pages
            for name, value in _attributes(page).items()
        }


def _attributes(page: Answer) -> dict[str, str]:
    """`INSTANCE/ATTRIBUTE` → value; the rows of attributes follow that of their instance."""
    found: dict[str, str] = {}
    instance = ""
    for row in page.rows:
        if row.kind.startswith("cfg-dt-instance"):
            instance = _checked_parameter_part(row)
        elif row.kind.startswith("cfg-ia-t") and instance:
            found[f"{instance}/{row.title}"] = row.get("value")
    return found


def _checked_parameter_part(row: Row) -> str:
    return row.title.rpartition("/")[2] or row.get("name")

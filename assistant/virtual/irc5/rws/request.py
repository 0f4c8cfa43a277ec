"""A request as the handlers see it, whichever dialect it came in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import Rejected
from assistant.virtual.irc5.rws.sessions import Session


@dataclass(frozen=True, slots=True)
class Request:
    """dialect: 1 or 2. path: as it was sent, without the query. query, form: by name.

    captures: the parts of the path that its route names. body: as it arrived.
    """

    dialect: int
    method: str
    path: str
    session: Session
    query: Mapping[str, str] = field(default_factory=dict)
    form: Mapping[str, str] = field(default_factory=dict)
    captures: Mapping[str, str] = field(default_factory=dict)
    body: bytes = b""
    accept: str = ""
    host: str = ""

    def either(self, one: str, two: str) -> str:
        """What differs between the dialects."""
        return one if self.dialect == 1 else two

    def given(self, name: str, *others: str) -> str:
        """A field of the form; raises Rejected if it is missing."""
        for one in (name, *others):
            if one in self.form:
                return self.form[one]
        raise Rejected(reasons.BAD_ARGUMENT, f"`{name}` is missing")

    def number(self, name: str, least: int, most: int, usual: int) -> int:
        """A whole number of the query."""
        text = self.query.get(name)
        if text is None:
            return usual
        if not text.isdecimal() or len(text) > 9:
            raise Rejected(reasons.BAD_ARGUMENT, f"`{name}` is no number")
        return min(max(int(text), least), most)

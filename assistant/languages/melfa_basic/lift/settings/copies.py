"""The passes of a divided procedure, one below the other, and the labels between them."""

from __future__ import annotations

from collections.abc import Callable

from assistant.languages.melfa_basic.lift.settings.forms import Form
from assistant.program import statements as p
from assistant.program.program import identifier


def in_order(head: Form) -> list[Form]:
    """The passes of a procedure; each stands above the one that it falls into if it can."""
    left = sorted(head.passes.values(), key=lambda one: (one.number, one.low))
    made: list[Form] = []
    following: Form | None = head
    while left:
        one = following if following in left else left[0]
        assert one is not None
        left.remove(one)
        made.append(one)
        following = one.falls
    return made


class Names:
    """Labels of the passes: `top`, `top_2` for the second one.

    spelled: names of the labels that stand between two lines, by their key.
    """

    def __init__(self, passes: list[Form], spelled: Callable[[int, int], dict[str, str]]) -> None:
        self.taken: set[str] = set()
        self.names: dict[int, dict[str, str]] = {}
        for one in sorted(passes, key=lambda one: (one.number, one.low)):
            own = self.names[id(one)] = {}
            for key, written in spelled(one.low, one.high).items():
                given = written if one.number == 1 else f"{written}_{one.number}"
                own[key] = identifier(given, self.taken)
                self.taken.add(own[key])

    def of(self, one: Form) -> dict[str, str]:
        return self.names[id(one)]


def leaves(body: list[p.Statement]) -> bool:
    """Whether nothing runs on below the last statement."""
    last = next((node for node in reversed(body) if not isinstance(node, p.Comment)), None)
    if isinstance(last, p.Opaque):
        return last.text.strip().lower() == "end"
    return isinstance(last, p.Goto | p.Return)

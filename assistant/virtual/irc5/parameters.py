"""System parameters: domains of types of instances, and the files that hold a domain.

They are kept, told, saved and loaded. What was set after the start changes nothing else here: a
real controller would take most of it over at its next start.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Final, Literal

from assistant.base.source_text import lines_of
from assistant.virtual.irc5.programs import TASK

if TYPE_CHECKING:
    from assistant.virtual.irc5.cabinet import Signal

PARAMETER_DOMAINS: Final = ("EIO", "MMC", "MOC", "PROC", "SIO", "SYS")
CFG_HEAD: Final = "{domain}:CFG_1.0:6:1::\n"
_CFG_HEAD: Final = re.compile(r"\s*(\w+):CFG_[\d.]+:")
_CFG_TYPE: Final = re.compile(r"^(\w+):[ \t]*$", re.MULTILINE)
_CFG_ATTRIBUTE: Final = re.compile(r'-(\w+)(?:[ \t]+("[^"]*"|[^\s"-][^\s"]*|-[\d.][^\s"]*))?')
INSTANCE_NAME: Final = ("Name", "name")
LoadMethod = Literal["add", "replace", "add-with-reset"]

Instance = dict[str, str]


class Parameters:
    """values: attributes by domain, type and instance."""

    def __init__(self, signals: Iterable[Signal], robot: str) -> None:
        rows = {
            one.name: {"Name": one.name, "SignalType": one.type, "Device": one.device}
            for one in signals
        }
        task = {"Name": TASK, "Type": "NORMAL", "Entry": "main", "MotionTask": "TRUE"}
        unit = {"name": "ROB_1", "use_robot_type": robot}
        self.values: dict[str, dict[str, dict[str, Instance]]] = {
            name: {} for name in PARAMETER_DOMAINS
        }
        self.values["EIO"]["EIO_SIGNAL"] = rows
        self.values["SYS"]["CAB_TASKS"] = {TASK: task}
        self.values["MOC"]["ROBOT"] = {"ROB_1": unit}

    def text(self, domain: str) -> str:
        """As the file of a domain."""
        said = [CFG_HEAD.format(domain=domain)]
        for type, instances in self.values[domain].items():
            said.append(f"#\n{type}:\n")
            for attributes in instances.values():
                row = " ".join(f'-{name} "{value}"' for name, value in attributes.items())
                said.append(f"\n      {row}\n")
        return "".join(said)

    def load(self, text: str, how: LoadMethod) -> None:
        """Takes a file over; raises ValueError for what is none, or for an instance that is there.

        how: `add` only what is new, `replace` what is there too, `add-with-reset` all of a type.
        """
        domain, types = parse_cfg(text)
        kept = self.values[domain]
        if how == "add":
            for type, instances in types.items():
                both = set(instances) & set(kept.get(type, {}))
                if both:
                    raise ValueError(f"{type} {min(both)} is there already")
        for type, instances in types.items():
            before = {} if how == "add-with-reset" else kept.get(type, {})
            kept[type] = {**before, **instances}


def parse_cfg(text: str) -> tuple[str, dict[str, dict[str, Instance]]]:
    """The domain of a file, and what it holds; raises ValueError."""
    head = _CFG_HEAD.match(text)
    if head is None or head[1].upper() not in PARAMETER_DOMAINS:
        raise ValueError("it does not begin with the name of a domain")
    found: dict[str, dict[str, Instance]] = {}
    lines = "\n".join(line for line in lines_of(text)[1:] if not line.lstrip().startswith("#"))
    places = list(_CFG_TYPE.finditer(lines))
    ends = [*(place.start() for place in places[1:]), len(lines)]
    for place, end in zip(places, ends, strict=False):
        body = lines[place.end() : end].replace("\\\n", " ")
        instances = found.setdefault(place[1], {})
        for row in lines_of(body):
            attributes = {
                name: (value or "TRUE").strip('"') for name, value in _CFG_ATTRIBUTE.findall(row)
            }
            if attributes:
                own = next((attributes[key] for key in INSTANCE_NAME if key in attributes), None)
                instances[own or str(len(instances))] = attributes
    return head[1].upper(), found

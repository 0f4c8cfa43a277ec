"""The data link: values to and from a program that has opened a line of the controller.

with DataLink("192.168.0.20:10003") as link:
    link.send(Joints((0, 10, 90, 0, 80, 0)))
    seconds, place = link.record(Form.parse("M_TIMER(1) | P_CURR"))
"""

from assistant.controllers.mitsubishi.data_link.link import DataLink
from assistant.controllers.mitsubishi.data_link.records import Form, Joints, Position
from assistant.controllers.mitsubishi.data_link.streams import Rate

__all__ = ["DataLink", "Form", "Joints", "Position", "Rate"]

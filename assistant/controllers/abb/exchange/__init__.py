"""Poses exchanged with a running RAPID program by files, over any client that keeps programs."""

from assistant.controllers.abb.exchange.exchange import PoseExchange
from assistant.controllers.abb.exchange.messages import Answer
from assistant.controllers.abb.exchange.module import LANGUAGE, Module, PlainFiles, Tool
from assistant.controllers.abb.exchange.plain import PlainExchange
from assistant.controllers.abb.exchange.poses import PoseSender
from assistant.controllers.abb.exchange.recording import Spent

__all__ = [
    "LANGUAGE",
    "Answer",
    "Module",
    "PlainExchange",
    "PlainFiles",
    "PoseExchange",
    "PoseSender",
    "Spent",
    "Tool",
]

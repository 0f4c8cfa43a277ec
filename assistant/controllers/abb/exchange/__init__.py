"""Poses exchanged with a running RAPID program by files, over any client that keeps programs."""

from assistant.controllers.abb.exchange.files import Answer
from assistant.controllers.abb.exchange.pose_sender import PoseSender, Spent
from assistant.controllers.abb.exchange.protocols import PlainExchange, PoseExchange
from assistant.controllers.abb.exchange.rapid_module import LANGUAGE, Module, PlainFiles, Tool

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

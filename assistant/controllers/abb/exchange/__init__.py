"""Poses exchanged with a running RAPID program by files, over any client that keeps programs."""

from assistant.controllers.abb.exchange.exchange import PoseExchange
from assistant.controllers.abb.exchange.messages import Answer
from assistant.controllers.abb.exchange.module import LANGUAGE, Module, Tool
from assistant.controllers.abb.exchange.recording import Spent

__all__ = ["LANGUAGE", "Answer", "Module", "PoseExchange", "Spent", "Tool"]

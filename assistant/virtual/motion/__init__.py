"""The motion of an arm that takes its time, under the interpreters of all languages.

docs/simulating.md states the model and its limits.
"""

from assistant.virtual.motion.timed import Timed
from assistant.virtual.motion.track import Track, track_of

__all__ = ["Timed", "Track", "track_of"]

"""Commands that write are cut off at every call that changes files: `python -m tests.sweep`."""

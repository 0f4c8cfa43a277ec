"""A bound for transfers by their progress."""

import threading

import pytest

from assistant.controllers.connection import LEAST_BYTES, TransferDeadline


def test_what_came_just_before_the_line_was_cut_counts_as_lost():
    cut = threading.Event()
    with pytest.raises(TimeoutError), TransferDeadline(0.01, cut.set):
        assert cut.wait(30)


def test_a_line_is_not_cut_behind_its_transfer():
    cut = threading.Event()
    before = {*threading.enumerate()}
    with TransferDeadline(5.0, cut.set) as pace:  # longer than any machine needs for this block
        pace.moved(LEAST_BYTES)
    for watching in {*threading.enumerate()} - before:
        watching.join()
    assert not cut.is_set()


def test_what_raises_in_a_line_that_was_cut_was_too_slow():
    cut = threading.Event()
    with pytest.raises(TimeoutError), TransferDeadline(0.01, cut.set):
        assert cut.wait(30)
        raise ConnectionError

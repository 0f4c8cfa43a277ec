"""Where commands of the controller link end, whatever pieces they come in."""

from hypothesis import given
from hypothesis import strategies as st

from assistant.virtual.cr.session import MOST_BYTES, Framing

COMMANDS = st.lists(
    st.binary(min_size=1, max_size=MOST_BYTES).filter(lambda c: not {10, 13} & set(c)), max_size=8
)
ENDS = st.sampled_from([b"\r", b"\r\n", b"\n"])


@given(COMMANDS, ENDS, st.lists(st.integers(1, 40), min_size=1))
def test_any_cutting_gives_the_same_commands(commands, end, sizes):
    stream = b"".join(command + end for command in commands)
    framing, got, at = Framing(), [], 0
    while at < len(stream):
        size = sizes[at % len(sizes)]
        got += framing.feed(stream[at : at + size])
        at += size
    assert got == commands
    assert not framing.ends_by_silence


@given(st.binary(min_size=1, max_size=MOST_BYTES).filter(lambda c: not {10, 13} & set(c)))
def test_silence_ends_a_command_without_end_code(command):
    framing = Framing()
    assert framing.feed(command) == []
    assert framing.ends_by_silence
    assert framing.silence() == [command]
    assert not framing.ends_by_silence


def test_a_client_that_sent_an_end_code_is_held_to_it():
    framing = Framing()
    assert framing.feed(b"1;1;STATE\r1;1;FDELAB") == [b"1;1;STATE"]
    assert not framing.ends_by_silence, "half a command must never be executed"
    assert framing.feed(b"C\r\n") == [b"1;1;FDELABC"]


@given(st.integers(MOST_BYTES + 1, 200_000))
def test_what_never_ends_takes_no_more_room(size):
    framing = Framing()
    for _ in range(3):
        framing.feed(b"x" * size)
    assert [len(c) for c in framing.silence()] == [MOST_BYTES + 1]

"""The packet on both sides, field by field as the manual has it; angles of poses."""

import struct

import numpy as np
import pytest

from assistant import languages
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi import external_control
from assistant.controllers.mitsubishi.external_control import MxtLink, program
from assistant.virtual.cr import mxt

# BFP-A3379-A, strdef.h of the sample program: offset and size of each member.
MANUAL = {
    "Command": (0, 2),
    "SendType": (2, 2),
    "RecvType": (4, 2),
    "reserve": (6, 2),
    "dat": (8, 40),
    "SendIOType": (48, 2),
    "RecvIOType": (50, 2),
    "BitTop": (52, 2),
    "BitMask": (54, 2),
    "IoData": (56, 2),
    "TCount": (58, 2),
    "CCount": (60, 4),
    "RecvType1": (64, 2),
    "reserve1": (66, 2),
    "dat1": (68, 40),
    "RecvType2": (108, 2),
    "reserve2": (110, 2),
    "dat2": (112, 40),
    "RecvType3": (152, 2),
    "reserve3": (154, 2),
    "dat3": (156, 40),
}


def test_the_client_knows_the_packet_of_the_manual():
    ours = {
        (offset, struct.calcsize("<" + form)) for offset, form, _ in external_control.PACKET_FIELDS
    }
    assert ours == set(MANUAL.values())
    assert [struct.calcsize("<" + form) for _, form, _ in external_control.PACKET_FIELDS] == [
        size for _, size in MANUAL.values()
    ]
    assert external_control.PACKET_LAYOUT.size == external_control.PACKET_SIZE == 196


def test_the_virtual_controller_knows_the_packet_of_the_manual():
    fields = mxt.PACKET.fields
    theirs = {name: (fields[name][1], fields[name][0].itemsize) for name in fields}
    assert theirs == MANUAL


def test_a_command_in_bytes():
    link = MxtLink("joint", 0.0035, mask=0x00FF, word=0x0011, first=900, signals=2, also=(11,))
    sent = link.command((90.0, -45.0, 0.0, 0.0, 180.0, 1.0), 0x01020304)
    assert len(sent) == 196
    assert sent[:8].hex() == "0100" + "0200" + "0800" + "0000"
    assert struct.unpack_from("<8f", sent, 8)[:2] == pytest.approx((np.pi / 2, -np.pi / 4))
    assert sent[48:64].hex() == "0100" + "0200" + "8403" + "ff00" + "1100" + "0000" + "04030201"
    assert sent[64:66].hex() == "0b00"


def test_the_first_packet_moves_nothing_and_asks_for_the_commanded_position():
    sent = MxtLink("pose", 0.0035).hello(0)
    assert sent[:6].hex() == "0000" + "0000" + "0100"
    assert sent[8:48] == bytes(40)


def test_a_sliding_axis_is_millimetres():
    link = MxtLink("joint", 0.0035, axes=4, sliding=(3,))
    sent = link.command((90.0, 0.0, 120.0, 0.0), 0)
    assert struct.unpack_from("<8f", sent, 8)[:3] == pytest.approx((np.pi / 2, 0.0, 120.0))


def test_short_packets_end_with_the_counter():
    link = MxtLink("joint", 64 / 9000, short=True, watched="command")
    assert len(link.command((1.0,) * 6, 7)) == 64
    assert link.command((1.0,) * 6, 7)[60:] == b"\7\0\0\0"
    reply = external_control.pack_packet({"recv_type": 2, "send_type": 2, "c_count": 9}, 64)
    assert link.read(reply).counter == 9
    assert link.read(reply + b"\0") is None


@pytest.mark.parametrize(
    "fields",
    [
        {"command": 7},
        {"send_type": 1},
        {"recv_type": 10, "send_type": 10},
        {"recv_type": 3, "send_type": 3},
        {"data": struct.pack("<f", float("nan")).ljust(40, b"\0")},
        {"data": struct.pack("<f", 1e30).ljust(40, b"\0")},
    ],
)
def test_a_reply_that_makes_no_sense_is_none(fields):
    link = MxtLink("joint", 0.0035)
    right = {"command": 1, "send_type": 2, "recv_type": 2}
    assert link.read(external_control.pack_packet(right)) is not None
    assert link.read(external_control.pack_packet({**right, **fields})) is None


def test_angles_of_poses_are_those_of_rotations():
    random = np.random.default_rng(5)
    for angles in random.uniform(-np.pi, np.pi, (200, 3)) * [1.0, 0.499, 1.0]:
        ours = external_control.quaternion_of_angles(*angles)
        theirs = rotations.from_euler(np.degrees(angles)[None, ::-1], "ZYX")[0]
        assert rotations.angle_between(np.array([ours]), theirs[None])[0] < 1e-6
        assert external_control.angles_of_quaternion(*ours) == pytest.approx(
            tuple(angles), abs=1e-9
        )
    for b in (np.pi / 2, -np.pi / 2):
        steep = external_control.quaternion_of_angles(0.7, b, 0.3)
        again = external_control.quaternion_of_angles(
            *external_control.angles_of_quaternion(*steep)
        )
        assert abs(np.dot(steep, again)) == pytest.approx(1.0)


@pytest.mark.parametrize("language", ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6"])
def test_the_program_is_one_that_the_language_reads(language):
    text = program("192.168.0.10", "joint", filter_ms=50)
    assert text.splitlines()[:2] == ['10 OPEN "ENET:192.168.0.10" AS #1', "20 MXT 1,1,50"]
    spoken = languages.get(language)
    assert [one for one in spoken.check([spoken.parse(text)]) if one.severity == "error"] == []


@pytest.mark.parametrize(
    "given", [{"pc": '1";END'}, {"filter_ms": -1}, {"file": 9}, {"pc": "host"}]
)
def test_a_program_of_something_else_is_refused(given):
    with pytest.raises(Refused) as refused:
        program(**{"pc": "127.0.0.1", **given})
    assert refused.value.findings[0].code == "CN731"

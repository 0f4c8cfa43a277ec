"""Files by Robot Web Services: whole or not at all."""

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers.rules import Lost
from tests.controllers.abb.rws.peer import Rws1, Rws2, refusal

GOOD = b"MODULE Seam\r\n  PROC main()\r\n  ENDPROC\r\nENDMODULE\r\n"
OTHER = GOOD.replace(b"main", b"other")


@pytest.fixture(params=[Rws1, Rws2])
def kind(request):
    return request.param


def codes(refused):
    return [finding.code for finding in refused.value.findings]


def home(peer, **files):
    """Files of HOME: by name."""
    return {f"{peer.home}/{name}": data for name, data in files.items()}


def test_a_module_goes_there_and_comes_back(kind):
    data = bytes(range(256)) * 40 + b"\r\n\n\r\r\n"
    with kind() as peer, peer.connect() as client:
        assert client.names() == () and client.read("seam.mod") is None
        for one in (GOOD, OTHER, data):
            client.write("seam.mod", one, as_it_was=True)
            assert client.read("seam.mod") == one
            assert peer.files == {f"{peer.home}/seam.mod": one}
        client.remove("seam.mod")
        client.remove("seam.mod")
        assert client.names() == () and peer.files == {}


def test_a_name_with_a_blank(kind):
    with kind() as peer, peer.connect() as client:
        client.write("seam 1.mod", GOOD)
        assert client.read("seam 1.mod") == GOOD and client.names() == ("seam 1.mod",)


def test_a_folder_of_the_address(kind):
    with kind() as peer:
        peer.files = {f"{peer.home}/parts/a.mod": GOOD, f"{peer.home}/b.mod": OTHER}
        with peer.connect(folder="/HOME:/parts") as client:
            assert client.names() == ("a.mod",) and client.read("a.mod") == GOOD
        with peer.connect() as client:
            assert client.names() == ("b.mod",)


@pytest.mark.parametrize(
    "name",
    [
        "",
        "../x.mod",
        "a/b.mod",
        "a\\b.mod",
        "x\r\nDELE y",
        "~x.mod",
        "-la",
        "ä.mod",
        "a?b",
        "$HOME",
    ],
)
def test_names_that_are_refused_before_anything_is_sent(kind, name):
    with kind() as peer, peer.connect() as client:
        peer.log.clear()
        for act in (client.read, client.remove, client.load, lambda n: client.write(n, GOOD)):
            with pytest.raises(Refused) as refused:
                act(name)
            assert codes(refused) == ["CN207"]
        assert peer.log == []


def test_a_controller_that_alters_a_byte_replaces_nothing(kind):
    with kind(alter=lambda data: data.replace(b"other", b"othex")) as peer:
        peer.files = home(peer, **{"seam.mod": GOOD})
        with pytest.raises(Refused) as refused, peer.connect() as client:
            client.write("seam.mod", OTHER)
        assert codes(refused) == ["CN206"] and peer.files == home(peer, **{"seam.mod": GOOD})
        assert f"byte {OTHER.index(b'other') + 4}" in refused.value.findings[0].message


def test_a_full_disk_leaves_the_old_one(kind):
    with kind() as peer:
        peer.files = home(peer, **{"seam.mod": GOOD})
        peer.answers[f"PUT /fileservice/{peer.home}/~seam.mod"] = (507, "")
        with pytest.raises(Refused) as refused, peer.connect() as client:
            client.write("seam.mod", OTHER)
        assert codes(refused) == ["CN205"] and "as it was" in str(refused.value)
        assert peer.files == home(peer, **{"seam.mod": GOOD})


def test_a_new_name_that_is_refused_gives_the_old_file_back(kind):
    with kind() as peer:
        peer.files = home(peer, **{"seam.mod": GOOD})
        suffix = "" if kind is Rws1 else "/rename"
        path = f"POST /fileservice/{peer.home}/~seam.mod{suffix}"
        peer.answers[path] = (403, refusal(-1073445881, "Rejected"))
        with pytest.raises(Refused) as refused, peer.connect() as client:
            client.write("seam.mod", OTHER)
        assert codes(refused) == ["CN301"] and peer.files == home(peer, **{"seam.mod": GOOD})


def test_no_file_of_somebody_else_is_in_the_way_or_lost(kind):
    others = {"seam.mod~": b"somebody kept this", "SEAM.MOD~~": b"and that"}
    with kind() as peer, peer.connect() as client:
        peer.files = home(peer, **{"seam.mod": GOOD}, **others)
        client.write("seam.mod", OTHER)
        assert peer.files == home(peer, **{"seam.mod": OTHER}, **others)


def test_a_file_whose_end_is_not_told_is_compared_with_its_size(kind):
    with kind() as peer:
        peer.files = home(peer, **{"seam.mod": GOOD})
        place = f"GET /fileservice/{peer.home}/seam.mod"
        peer.answers[place] = (200, GOOD[:9], {"Content-Length": None})
        with peer.connect() as client, pytest.raises(Refused) as refused:
            client.read("seam.mod")
        assert codes(refused) == ["CN222"]
        peer.answers[place] = (200, GOOD, {"Content-Length": None})
        with peer.connect() as client:
            assert client.read("seam.mod") == GOOD


@pytest.mark.parametrize("name", ["..", "a/b", "a\\b"])
def test_a_listing_that_leads_elsewhere_is_not_followed(kind, name, tmp_path):
    with kind() as peer:
        listing = f'<ul><li class="fs-file" title="{name}"></li></ul>'
        peer.answers[f"GET /fileservice/{peer.home}"] = f"<html>{listing}</html>"
        with pytest.raises(Refused) as refused, peer.connect():
            pass
        assert codes(refused) == ["CN222"] and not isinstance(refused.value, Lost)

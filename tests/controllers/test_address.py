"""Addresses: what they say, what is refused, and that no password is ever repeated."""

from urllib.parse import unquote

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused
from assistant.controllers.address import SCHEMES, Address, parse

GOOD = {
    "ftp://engineer@192.168.125.1": Address("ftp", "192.168.125.1", 21, "engineer", "HOME:"),
    "ftp://a%20b@irc5:2121/HOME:/parts/": Address("ftp", "irc5", 2121, "a b", "HOME:/parts"),
    "ftp://Default%20User@irc5": Address("ftp", "irc5", 21, "Default User", "HOME:"),
    "FTPS://x@IRC5": Address("ftps", "irc5", 21, "x", "HOME:"),
    "ftp://irc5": Address("ftp", "irc5", 21, None, "HOME:"),
    "melfa://192.168.0.20": Address("melfa", "192.168.0.20", 10001),
    "melfa://cr:10002/": Address("melfa", "cr", 10002),
    "melfa://[::1]:10001": Address("melfa", "::1", 10001),
    "melfa://cr?end=none": Address("melfa", "cr", 10001, options=(("end", "none"),)),
    "melfa-serial:///dev/ttyS0": Address("melfa-serial", "/dev/ttyS0", 0),
    "melfa-serial://COM3": Address("melfa-serial", "COM3", 0),
    "melfa-serial:///dev/pts/3?parity=none&baud=19200&stop=1&bits=8&framing=procedural": Address(
        "melfa-serial",
        "/dev/pts/3",
        0,
        options=(
            *(("baud", "19200"), ("bits", "8"), ("framing", "procedural")),
            *(("parity", "none"), ("stop", "1")),
        ),
    ),
}


@pytest.mark.parametrize("text", GOOD)
def test_good_addresses(text):
    assert parse(text) == GOOD[text]
    assert parse(str(GOOD[text])) == GOOD[text]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "CN101"),
        ("irc5", "CN103"),
        ("http://irc5", "CN103"),
        ("ftp://", "CN101"),
        ("ftp://user@", "CN101"),
        ("ftp://irc5:0", "CN101"),
        ("ftp://irc5:99999", "CN101"),
        ("ftp://irc5:port", "CN101"),
        ("ftp://irc5/../etc", "CN101"),
        ("ftp://irc5/a%2F..%2F../etc", "CN101"),
        ("ftp://irc5/a%0d%0aDELE x", "CN101"),
        ("ftp://u%0aser@irc5", "CN101"),
        ("ftp://irc5/x?y=1", "CN101"),
        ("ftp://irc5\r\nDELE x", "CN101"),
        ("ftp://[::1", "CN101"),
        ("melfa://user@cr", "CN101"),
        ("melfa://cr/folder", "CN101"),
        ("melfa://cr?end=lf", "CN101"),
        ("melfa://cr?end=cr&end=crlf", "CN101"),
        ("melfa://cr?end", "CN101"),
        ("melfa://cr?baud=9600", "CN101"),
        ("melfa://cr#end=cr", "CN101"),
        ("melfa-serial://", "CN101"),
        ("melfa-serial://host/dev/ttyS0", "CN101"),
        ("melfa-serial://COM3:9600", "CN101"),
        ("melfa-serial:///dev/../etc/passwd", "CN101"),
        ("melfa-serial:///dev/tty S0", "CN101"),
        ("melfa-serial:///dev/ttyS0?baud=fast", "CN101"),
        ("melfa-serial:///dev/ttyS0?parity=mark", "CN101"),
    ],
)
def test_what_is_refused(text, code):
    with pytest.raises(Refused) as refused:
        parse(text)
    assert [finding.code for finding in refused.value.findings] == [code]


@given(
    st.sampled_from([*SCHEMES, "http"]),
    st.text(min_size=1, max_size=20).map(lambda t: f"Geheim{t}7"),
    st.sampled_from(["", ":21", ":nonsense", "/a/b"]),
)
def test_a_password_is_refused_and_never_shown(scheme, password, rest):
    with pytest.raises(Refused) as refused:
        parse(f"{scheme}://user:{password}@host{rest}")
    finding = refused.value.findings[0]
    shown = "".join(filter(None, [finding.message, finding.cure, finding.place]))
    assert "Geheim" not in shown and "Geheim" not in str(refused.value)


@given(
    st.sampled_from(sorted(name for name, scheme in SCHEMES.items() if not scheme.device)),
    st.from_regex(r"[a-z][a-z0-9-]{0,20}(\.[a-z0-9]{1,8})?", fullmatch=True),
    st.integers(1, 65535),
    st.none() | st.text(st.characters(codec="utf-8", categories=["L", "N", "Zs", "P"]), min_size=1),
)
@example("ftp", "irc5", 21, "%41")
@example("ftp", "irc5", 21, ":")
@example("ftp", "irc5", 21, "a/:geheim")
@example("ftp", "irc5", 21, "@:geheim")
@example("ftp", "irc5", 21, "a%253Ageheim")
def test_an_address_survives_being_written(scheme, host, port, user):
    """Unless a `:` is in the user, however it is quoted: what follows it may be a password."""
    address = Address(scheme, host, port, user if SCHEMES[scheme].login else None)
    if address.folder != SCHEMES[scheme].folder:
        address = Address(scheme, host, port, address.user, SCHEMES[scheme].folder)
    plain = address.user or ""
    while plain != (plain := unquote(plain)):
        pass
    if ":" not in plain:
        assert parse(str(address)) == address
        return
    with pytest.raises(Refused) as refused:
        parse(str(address))
    assert [finding.code for finding in refused.value.findings] == ["CN102"]
    assert "geheim" not in str(refused.value)


@pytest.mark.parametrize("text", GOOD)
def test_a_label_is_one_safe_folder(text):
    label = parse(text).label
    assert label and not set(label) & set('/\\:*?"<>| ') and ".." not in label

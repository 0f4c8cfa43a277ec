"""Which addresses have what is sent to them go over the network unencrypted."""

from __future__ import annotations

from ipaddress import ip_address
from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.controllers import rules
from assistant.controllers.address import Address

CLEAR_TEXT_CURES: Final = {
    "rws": "an OmniCore speaks `rwss://`, which is encrypted",
    "melfa": "the controller link knows neither encryption nor a login: let nobody else reach it",
}
"""Scheme without a password in clear text (Robot Web Services 1.0 have Digest) → what to do."""


def clear_text_finding(address: Address) -> Diagnostic | None:
    """The finding of an address that is not encrypted; None if it is, or on this computer."""
    if _is_this_computer(address.host):
        return None
    if address.scheme == "ftp":
        return rules.CLEAR_LOGIN(place=str(address), address=address)
    if address.scheme in CLEAR_TEXT_CURES:
        return rules.CLEAR(
            place=str(address), address=address, cure=CLEAR_TEXT_CURES[address.scheme]
        )
    return None


def _is_this_computer(host: str) -> bool:
    """Whether what is sent there never leaves this computer."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"

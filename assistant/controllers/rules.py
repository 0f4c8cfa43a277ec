"""Findings of the clients of controllers; each says what state the controller is in."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Refused, Rule, Severity

ERROR: Final = Severity.ERROR

BAD_ADDRESS = Rule(
    "CN101",
    ERROR,
    "the address cannot be used: {reason}",
    "write it as `ftp://user@host:port/folder`, `ftps://…` or `melfa://host:port`",
)
PASSWORD_IN_ADDRESS = Rule(
    "CN102",
    ERROR,
    "the address holds a password, which would end up in histories and logs",
    "leave it out; set ROBOT_ASSISTANT_PASSWORD, store it with keyring, or type it when asked",
)
UNKNOWN_SCHEME = Rule("CN103", ERROR, "no controller is reached by `{given}`", "use {known}")
NO_USER = Rule(
    "CN111",
    ERROR,
    "no user is known for {address}",
    "write it into the address (`ftp://user@host`) or set ROBOT_ASSISTANT_USER",
)
NO_PASSWORD = Rule(
    "CN112",
    ERROR,
    "no password is known for user `{user}` of {address}",
    "set ROBOT_ASSISTANT_PASSWORD, store it with keyring, or run where it can be asked for",
)
UNREACHABLE = Rule(
    "CN201",
    ERROR,
    "{address} cannot be reached: {reason}; nothing was changed by that",
    "check that the controller is on, the cable, the address and the port",
)
LOGIN = Rule(
    "CN202",
    ERROR,
    "{address} did not let user `{user}` in: {reply}; nothing was changed by that",
    "check the user and the password",
)
NO_FOLDER = Rule(
    "CN203",
    ERROR,
    "{address} has no folder `{folder}`: {reply}; nothing was changed by that",
    "write the folder into the address, as in `ftp://user@host/HOME:/parts`",
)
LOST = Rule(
    "CN204",
    ERROR,
    "the connection was lost while {doing}: {reason}; {state}",
    "check the controller and the cable, then run it again",
)
REFUSED = Rule(
    "CN205",
    ERROR,
    "the controller refused {doing}: {reply}; {state}",
    "put right what it says, then run it again",
)
ALTERED = Rule(
    "CN206",
    ERROR,
    "`{name}` came back other than it was sent ({sent} bytes sent, {back} read back, first "
    "difference at byte {at}); {state}",
    "check the transfer mode of the controller's server, the disk and the line",
)
FILE_NAME = Rule(
    "CN207",
    ERROR,
    "`{name}` cannot be a file on this controller: {reason}",
    "rename it",
)
CERTIFICATE = Rule(
    "CN208",
    ERROR,
    "{address} showed no certificate that can be trusted: {reason}; nothing was changed by that",
    "name the file that holds its certificate",
)
ALARM = Rule(
    "CN301",
    ERROR,
    "the controller answered error {number} ({text}) to {doing}; {state}",
    "{cure}",
)
GARBLED = Rule(
    "CN302",
    ERROR,
    "the answer to {doing} makes no sense: {answer}; {state}",
    "check that the port is a controller link (parameter CPRCE11 = 0) and not used by others",
)
LINE_REFUSED = Rule(
    "CN303",
    ERROR,
    "the controller refused this line of `{name}` with error {number} ({text}); {state}",
    "{cure}",
)
LINE_TOO_LONG = Rule(
    "CN304",
    ERROR,
    "the line has {length} bytes, the controller link carries {most}; nothing was sent",
    "split the line",
)
LINE_CHARACTER = Rule(
    "CN305",
    ERROR,
    "the line holds a control character (code {code}); nothing was sent",
    "remove it",
)


class Lost(Refused):
    """There is no connection (any more): what was under way may or may not have happened."""

    exit_status = 2

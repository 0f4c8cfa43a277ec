"""Findings of the clients of controllers; each states the condition of the controller.

Modes with particular findings have a separate `rules.py` (cyclic control, the pose exchange of ABB
controllers, the lines of Mitsubishi controllers).
"""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Refused, Severity, error, info, warning
from assistant.base.installation import missing_extra

ERROR: Final = Severity.ERROR

BAD_ADDRESS = error(
    "CN101",
    "the address cannot be used: {reason}",
    "write it as `ftp://user@host:port/folder`, `rws://host` (ABB), `melfa://host:port` or "
    "`melfa-serial:///dev/ttyS0` (Mitsubishi)",
)
PASSWORD_IN_ADDRESS = error(
    "CN102",
    "the address holds a password, which would end up in histories and logs",
    "leave it out; set ROBOT_ASSISTANT_PASSWORD, store it with keyring, or type it when asked",
)
UNKNOWN_SCHEME = error("CN103", "no controller is reached by `{given}`", "use {known}")
NO_SCHEME = error(
    "CN117",
    "nothing says how `{host}` is reached",
    "write `melfa://{host}` (Mitsubishi CR), `rws://{host}` or `ftp://{host}` (ABB IRC5), "
    "`rwss://{host}` or `sftp://{host}` (ABB OmniCore)",
)
VIRTUAL_ADDRESS = error(
    "CN118",
    "only {known} are virtual controllers, and only assistant.toml may name them",
    "write one of them as `address` of a controller in [controllers] of assistant.toml",
)
UNKNOWN_NAME = error(
    "CN104",
    "no project names a controller `{name}`; those that are named: {known}",
    "write `{name}` with its address into [controllers] of assistant.toml, or give the address",
)
BAD_NAME = error(
    "CN105",
    "`{name}` cannot be the name of a controller",
    "write letters, digits, `_` and `-`, a letter first",
)
PASSWORD_IN_FILE = error(
    "CN106",
    "the file holds a password of `{name}`, where everybody can read it who has the project",
    "take it out and change it; set {variable}, store it with keyring, or type it when asked",
)
NO_TABLE_OF_CONTROLLERS = error(
    "CN107", "`{key}` is no table", 'write lines such as cell1 = "melfa://192.168.0.20" in it'
)
NO_ADDRESS = error(
    "CN108", "`{name}` has no address", 'write address = "melfa://192.168.0.20" or the like'
)
TWO_USERS = error("CN109", "`{name}` has two users, `{one}` and `{other}`", "keep one of them")
SAME_VARIABLE = error(
    "CN110",
    "`{name}` and `{other}` would find their passwords in the same environment variable",
    "rename one of them",
)
ONLY_DEPLOYED = error(
    "CN113",
    "`{name}` is a virtual controller that runs only as long as a command speaks with it",
    "start `robot-assistant virtual {kind}` and write the address that it tells, to have it go on",
)
NO_USER = error(
    "CN111",
    "no user is known for {address}",
    "write it into the address (`ftp://user@host`) or set ROBOT_ASSISTANT_USER",
)
NO_PASSWORD = error(
    "CN112",
    "no password is known for user `{user}` of {address}",
    "set ROBOT_ASSISTANT_PASSWORD, store it with keyring, or run where it can be asked for",
)
USER_AND_PASSWORD = error(
    "CN114",
    "the user that is stated for {address} holds a `:`, and may hold a password after it",
    "state the user alone; the password has a variable of its own, ROBOT_ASSISTANT_PASSWORD",
)
CLEAR_LOGIN = warning(
    "CN115",
    "user, password and programs go to {address} in clear text: who can listen on the way can read "
    "and change them",
    "take `ftps://` or `sftp://` where the controller or a gateway has it, else a network of its "
    'own, and write CN115 = "off" into [severity] of assistant.toml',
)
CLEAR = info(
    "CN116",
    "programs and commands go to {address} in clear text: who can listen on the way can read and "
    "change them",
    '{cure}; where the network is the controller\'s own, write CN116 = "off" into [severity] of '
    "assistant.toml",
)
UNREACHABLE = error(
    "CN201",
    "{address} cannot be reached: {reason}; nothing was changed by that",
    "check that the controller is on, the cable, the address and the port",
)
LOGIN = error(
    "CN202",
    "{address} did not let user `{user}` in: {reply}; nothing was changed by that",
    "check the user and the password",
)
NO_FOLDER = error(
    "CN203",
    "{address} has no folder `{folder}`: {reply}; nothing was changed by that",
    "write the folder into the address, as in `ftp://user@host/HOME:/parts`",
)
FOUND_FOLDER = info(
    "CN223",
    "{address} has no `{wanted}` where the login begins; `{folder}` is used instead",
    "write the folder into the address to have it entered at once",
)
LOGIN_FOLDER = warning(
    "CN224",
    "{address} has neither `HOME:` nor another folder of that name; `{folder}`, where the login "
    "begins, is used instead",
    "write the folder of the programs into the address, as in `ftp://user@host/parts`",
)
SEVERAL_FOLDERS = error(
    "CN225",
    "{address} has no `HOME:`, but several systems with a folder of that name: {listed}; nothing "
    "was changed by that",
    "write the folder of the system that runs into the address: `ftp://user@host/{first}`",
)
LOST = error(
    "CN204",
    "the connection was lost while {doing}: {reason}; {state}",
    "check the controller and the cable, then run it again",
)
REFUSED = error(
    "CN205",
    "the controller refused {doing}: {reply}; {state}",
    "put right what it says, then run it again",
)
ALTERED = error(
    "CN206",
    "`{name}` came back other than it was sent ({sent} bytes sent, {back} read back, first "
    "difference at byte {at}); {state}",
    "check the transfer mode of the controller's server, the disk and the line",
)
FILE_NAME = error("CN207", "`{name}` cannot be a file on this controller: {reason}", "rename it")
CERTIFICATE = error(
    "CN208",
    "{address} showed no certificate that can be trusted: {reason}; nothing was changed by that",
    "write the file that holds its certificate, or that of its authority, into the project: "
    '`certificate = "cell1.pem"` in the controller\'s table of assistant.toml, docs/controllers',
)
NO_TLS = error(
    "CN214",
    "{address} does not go over to TLS: {reply}; {state}",
    "switch TLS on there, or have a gateway do it; `ftp://` goes without, in clear text",
)
NOT_KEPT = error(
    "CN219",
    "`{name}` cannot be kept on this computer: {reason}; nothing was changed by that",
    "free space or name another file",
)
HOST_KEY = error(
    "CN211",
    "{address} cannot be trusted: {reason}; no password was sent",
    "compare the key with that of the controller, then add it to the known hosts, or write its "
    "fingerprint into the address: `sftp://user@host?fingerprint=SHA256:…`",
)
NEEDS_SFTP = missing_extra(
    "CN212",
    "SFTP needs paramiko, which is not installed",
    "sftp",
)
SHORT = error(
    "CN213",
    "`{name}` has {there} bytes on the controller, and {back} came, or it has changed meanwhile; "
    "nothing was changed by that",
    "check the line, then run it again",
)
ALARM = error(
    "CN301", "the controller answered error {number} ({text}) to {doing}; {state}", "{cure}"
)
GARBLED = error(
    "CN302",
    "the answer to {doing} makes no sense: {answer}; {state}",
    "check that the port is a controller link (parameter CPRCE11 = 0) and not used by others",
)
LINE_REFUSED = error(
    "CN303",
    "the controller refused this line of `{name}` with error {number} ({text}); {state}",
    "{cure}",
)
LINE_TOO_LONG = error(
    "CN304",
    "the line has {length} bytes, the controller link carries {most}; nothing was sent",
    "split the line",
)
LINE_CHARACTER = error(
    "CN305", "the line holds a control character (code {code}); nothing was sent", "remove it"
)
RIGHT_HELD = error(
    "CN306",
    "the operation right of {address} could not be given back: {reason}; it may still be held",
    "connect again, or enable the teaching box for a moment, before others need it",
)
NOT_DONE = error(
    "CN307",
    "{doing} did not come to its end within {seconds:g} s; {state}",
    "look at the controller: its state, its mode and what stands in its way",
)
BAD_VALUE = error(
    "CN308", "`{value}` cannot be {what}: {reason}; nothing was sent", "write it as {form}"
)
OUT_OF_LIMITS = error(
    "CN309",
    "{axis} would go to {value:g}, beyond its limits {least:g} to {most:g}; nothing moved",
    "go less far",
)
NOT_TAKEN = error(
    "CN310",
    "{what} was accepted, but the controller has `{back}` for it and not `{sent}`",
    "check what values it may have, and whether another client changes it",
)
NOT_STOPPED = error(
    "CN311",
    "{address} could not be told to stop: {reason}; the arm may still move",
    "press the emergency stop",
)
NO_PARAMETERS = error(
    "CN312", "`{file}` is no parameter file: {reason}", "take a .PRM file of RT ToolBox"
)
STANDS = error("CN313", "{what} is not possible: {reason}; nothing was started", "{cure}")
BACKUP_EXISTS = error("CN401", "`{folder}` is there already; nothing was written", "name a new one")
BACKUP_WRITE = error(
    "CN402",
    "the backup cannot be written to `{folder}`: {reason}; nothing of it is left",
    "free the place or name another one",
)
NO_BACKUP = error(
    "CN403",
    "`{folder}` is no backup that could be restored: {reason}; nothing was changed by that",
    "take a folder as `backup` wrote it",
)
NOT_IN_BACKUP = error(
    "CN404", "the backup has no `{name}`; nothing was changed by that", "take one of {known}"
)
RESTORED_PARTLY = error(
    "CN405",
    "restoring stopped at `{name}`; restored by then: {done}",
    "put right what the other finding says and restore again; what was there before is in `{kept}`",
)
LEFT_OUT = warning(
    "CN406",
    "the controller has {count} files that are no programs and are not in the backup: {names}",
    "keep them by RT ToolBox if they are wanted; all of their names are in `{file}`",
)
NEEDS_RWS = missing_extra(
    "CN220",
    "Robot Web Services need httpx and websockets, which are not installed",
    "rws",
)
MAY_BE_HELD = error(
    "CN221",
    "the {right} of {address} may still be held by the session whose line was cut",
    "wait five minutes until that session has ended, or release it on the FlexPendant",
)
GARBLED_WEB = error(
    "CN222",
    "the answer to {doing} makes no sense: {answer}; {state}",
    "check the port, and that it is `rws://` up to RobotWare 6 and `rwss://` from 7 on",
)
NOT_HERE = error(
    "CN209",
    "{address} cannot {what}: {reason}; nothing was changed by that",
    "{cure}",
)

OTHER_PROGRAM = error(
    "CN230",
    "another program is called `{name}` on the controller; nothing was changed",
    "back it up and delete it, or allow to replace it",
)


class Lost(Refused):
    """There is no connection (any more): what was under way may or may not have happened."""

    exit_status = 2


class Taken(Refused):
    """Another user, or a dead session, has it open; it may be free again in a moment."""


NO_JOINTS: Final = error(
    "CN651",
    "the controller says that its tool is at {point}, where the arm has no joints for it",
    "state the tool that the program on the controller has, and the robot that it moves",
)
NO_SLOWER: Final = warning(
    "CN652",
    "the controller goes at {percent:g} % at least, at which tool and axes may be {times} times as "
    "fast as they should",
    "keep out of its reach, state higher speeds, or lead it cycle by cycle (--by mxt, --by egm)",
)
OWN_SPEED: Final = warning(
    "CN653",
    "the program on the controller decides how fast the arm moves, and not this command",
    "write the speed into that program: `exchange module --speed`",
)

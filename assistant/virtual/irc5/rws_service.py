"""The service behind both servers of Robot Web Services: the table of routes, and log-out.

One row of the table is an operation, for both dialects. Paths as of the reference, 4.3, and of the
path tables of the public client ichbinmeraj/abb-rws-client (src/paths), which were tested on
RobotWare 6.16 and 7.21. What follows a `?` is the `action` (or `resource`) that the query names.
`{name}` is one part of a path, `{name...}` any number of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Final, NamedTuple

from assistant.virtual.irc5 import rws_files, rws_hardware, rws_messages, rws_rapid, rws_system
from assistant.virtual.irc5.cabinet import MASTERSHIP_DOMAINS, Cabinet
from assistant.virtual.irc5.rws_faults import Faults, certify
from assistant.virtual.irc5.rws_http import Server, Site
from assistant.virtual.irc5.rws_messages import (
    Answer,
    Rejected,
    Request,
    Session,
    Sessions,
    find_route,
    make_route,
)
from assistant.virtual.irc5.rws_subscriptions import Subscriptions

_Handler = Callable[[Cabinet, Request], Answer]


class _Row(NamedTuple):
    """Row of a route. one, two: the path in each dialect, empty where it has none.

    needs: the domain whose mastership it takes, followed by `?` if it is enough that no other
    client holds that.
    """

    method: str
    one: str
    two: str
    handler: _Handler
    needs: str = ""


E: Final = "/rw/rapid/execution"
D: Final = "/rw/rapid/symbol"
S: Final = "/rw/iosystem/signals"
H: Final = "/rw/mastership"
F: Final = "/fileservice"
P: Final = "/rw/panel"
C: Final = "/rw/cfg"
_C2: Final = "/rw/cfg/{domain}/{type}/instances"
T: Final = "/rw/rapid/tasks/{task}"
U: Final = "/rw/motionsystem/mechunits/{unit}"
M2: Final = f"{T}/modules/{{module}}"

_ROWS: Final = (
    _Row("GET", f"{P}/ctrlstate", f"{P}/ctrl-state", rws_hardware.motor_state),
    _Row("POST", f"{P}/ctrlstate?setctrlstate", f"{P}/ctrl-state",
        rws_hardware.set_motor_state, "motion?"),
    _Row("GET", f"{P}/opmode", f"{P}/opmode", rws_hardware.operating_mode),
    _Row("POST", f"{P}/opmode", f"{P}/opmode", rws_hardware.set_operating_mode),
    _Row("GET", f"{P}/speedratio", f"{P}/speedratio", rws_hardware.speed_ratio),
    _Row("POST", *((f"{P}/speedratio?setspeedratio",) * 2), rws_hardware.set_speed_ratio, "rapid"),
    _Row("GET", f"{P}/coldetstate", f"{P}/coldetstate", rws_hardware.collision_detection),
    _Row("POST", "", f"{P}/emergency-stop", rws_hardware.emergency_stop),
    _Row("GET", E, E, rws_rapid.execution_state),
    _Row("POST", f"{E}?start", f"{E}/start", rws_rapid.start_execution, "rapid?"),
    _Row("POST", f"{E}?stop", f"{E}/stop", rws_rapid.stop_execution),
    _Row("POST", f"{E}?resetpp", f"{E}/resetpp", rws_rapid.reset_pointer, "rapid"),
    _Row("POST", f"{E}?setcycle", f"{E}/cycle", rws_rapid.set_cycle, "rapid?"),
    _Row("POST", f"{E}?startprodentry", f"{E}/startprodentry",
        rws_rapid.start_production, "rapid"),
    _Row("GET", "/rw/rapid/tasks", "/rw/rapid/tasks", rws_rapid.list_tasks),
    _Row("GET", T, T, rws_rapid.task_facts),
    _Row("POST", f"{T}?activate", "/rw/rapid/tasks/activate", rws_rapid.activate_task, "rapid"),
    _Row("POST", f"{T}?deactivate", "/rw/rapid/tasks/deactivate",
        rws_rapid.deactivate_task, "rapid"),
    _Row("GET", "/rw/rapid/modules", f"{T}/modules", rws_rapid.list_modules),
    _Row("GET", "/rw/rapid/modules/{module}", M2, rws_rapid.module_facts),
    _Row("GET", f"{T}/modules/{{module}}", "", rws_rapid.module_facts),
    _Row("GET", "/rw/rapid/modules/{module}?module-text", f"{M2}/text", rws_rapid.module_text),
    _Row("POST", "", f"{M2}/text", rws_rapid.set_module_text, "rapid"),
    _Row("POST", "/rw/rapid/modules/{module}?save", f"{M2}/save", rws_rapid.save_module),
    _Row("POST", f"{T}?loadmod", f"{T}/loadmod", rws_rapid.load_module, "rapid"),
    _Row("POST", f"{T}?unloadmod", f"{T}/unloadmod", rws_rapid.unload_module, "rapid"),
    _Row("GET", f"{T}/program", f"{T}/program", rws_rapid.program_facts),
    _Row("POST", f"{T}/program?loadprog", f"{T}/program/load", rws_rapid.load_program, "rapid"),
    _Row("GET", f"{T}/pcp", f"{T}/pcp", rws_rapid.read_pointer),
    _Row("POST", f"{T}/pcp?set-pp-routine", f"{T}/pcp/routine", rws_rapid.set_pointer, "rapid"),
    _Row("POST", "", f"{T}/pcp/reset", rws_rapid.reset_pointer, "rapid"),
    _Row("POST", f"{D}/data?validate", f"{D}/RAPID/{{task}}/data?validate",
        rws_rapid.validate_value),
    _Row("GET", f"{D}/data/RAPID/{{symbol...}}", f"{D}/RAPID/{{symbol...}}/data",
        rws_rapid.read_symbol),
    _Row("POST", f"{D}/data/RAPID/{{symbol...}}?set", f"{D}/RAPID/{{symbol...}}/data",
        rws_rapid.write_symbol, "rapid"),
    _Row("GET", f"{D}/properties/RAPID/{{symbol...}}", f"{D}/RAPID/{{symbol...}}/properties",
        rws_rapid.symbol_properties),
    _Row("POST", "/rw/rapid/symbols?search-symbols", "/rw/rapid/symbols/search",
        rws_rapid.search_symbols),
    _Row("POST", "/rw/rapid/symbols?search-symbol", "", rws_rapid.search_symbols),
    _Row("GET", S, S, rws_hardware.list_signals),
    _Row("POST", f"{S}?signal-search", f"{S}/signal-search", rws_hardware.search_signals),
    _Row("GET", *((f"{S}/{{signal...}}",) * 2), rws_hardware.read_signal),
    _Row("POST", f"{S}/{{signal...}}?set", f"{S}/{{signal...}}/set-value",
        rws_hardware.write_signal),
    _Row("GET", "/rw/iosystem/networks", "/rw/iosystem/networks", rws_hardware.list_networks),
    _Row("GET", "/rw/iosystem/devices", "/rw/iosystem/devices", rws_hardware.list_devices),
    _Row("GET", "/rw/motionsystem", "/rw/motionsystem", rws_hardware.motion_system),
    _Row("GET", "/rw/motionsystem?change-count", "/rw/motionsystem?change-count",
        rws_hardware.motion_system),
    _Row("GET", "/rw/motionsystem/mechunits", "/rw/motionsystem/mechunits",
        rws_hardware.mechanical_units),
    _Row("GET", U, U, rws_hardware.mechanical_unit),
    _Row("GET", f"{U}?static", "", rws_hardware.mechanical_unit),
    _Row("GET", f"{U}?dynamic", "", rws_hardware.mechanical_unit),
    _Row("GET", f"{U}/jointtarget", f"{U}/jointtarget", rws_hardware.joint_target),
    _Row("GET", f"{U}/robtarget", f"{U}/robtarget", rws_hardware.robot_target),
    _Row("GET", f"{U}/cartesian", f"{U}/cartesian", rws_hardware.cartesian_pose),
    _Row("GET", H, H, rws_system.list_mastership),
    _Row("GET", f"{H}/{{domain}}", f"{H}/{{domain}}", rws_system.mastership_holder),
    _Row("POST", f"{H}?request", f"{H}/request", rws_system.take_mastership),
    _Row("POST", f"{H}?release", f"{H}/release", rws_system.release_mastership),
    _Row("POST", f"{H}/{{domain}}?request", f"{H}/{{domain}}/request", rws_system.take_mastership),
    _Row("POST", f"{H}/{{domain}}?release", f"{H}/{{domain}}/release",
        rws_system.release_mastership),
    _Row("GET", "/rw/elog", "/rw/elog", rws_system.event_domains),
    _Row("POST", "/rw/elog?clearall", "/rw/elog/clearall", rws_system.clear_events),
    _Row("GET", "/rw/elog/{domain}", "/rw/elog/{domain}", rws_system.event_messages),
    _Row("POST", "/rw/elog/{domain}?clear", "/rw/elog/{domain}/clear", rws_system.clear_events),
    _Row("GET", "/rw/elog/{domain}/{number}", "/rw/elog/{domain}/{number}",
        rws_system.event_message),
    _Row("GET", C, C, rws_files.parameter_domains),
    _Row("POST", f"{C}?load", f"{C}/load", rws_files.load_parameters, "cfg"),
    _Row("POST", f"{C}?validate", "", rws_files.validate_parameters),
    _Row("GET", f"{C}/{{domain}}", f"{C}/{{domain}}", rws_files.parameter_types),
    _Row("POST", f"{C}/{{domain}}?saveas", f"{C}/{{domain}}/saveas", rws_files.save_parameters),
    _Row("GET", _C2, _C2, rws_files.parameter_instances),
    _Row("GET", f"{_C2}/{{instance}}", f"{_C2}/{{instance}}", rws_files.parameter_instance),
    _Row(
        "POST", f"{_C2}/{{instance}}?set", f"{_C2}/{{instance}}", rws_files.change_parameter, "cfg"
    ),
    _Row("GET", "/rw/system", "/rw/system", rws_system.system_info),
    _Row("GET", "/rw/system/options", "/rw/system/options", rws_system.system_options),
    _Row("GET", "/rw/system/robottype", "/rw/system/robottype", rws_system.robot_type),
    _Row("GET", "/ctrl", "/ctrl", rws_system.controller_identity),
    _Row("GET", "/ctrl/identity", "/ctrl/identity", rws_system.controller_identity),
    _Row("GET", "/ctrl/clock", "/ctrl/clock", rws_system.read_clock),
    _Row("PUT", "/ctrl/clock", "/ctrl/clock", rws_system.set_clock),
    _Row("GET", "/ctrl/backup", "/ctrl/backup", rws_system.backup_state),
    _Row("GET", "/ctrl/backup?backupstate", "/ctrl/backup/state", rws_system.backup_ready),
    _Row("GET", "/progress/{number}", "/progress/{number}", rws_system.read_progress),
    _Row("POST", "/ctrl/backup?backup", "/ctrl/backup/create", rws_system.create_backup),
    _Row(
        "POST", "/ctrl/backup?restore", "/ctrl/backup/restore", rws_system.restore_backup, "rapid"
    ),
    _Row("POST", "", "/ctrl/backup/check-restore", rws_system.check_backup),
    _Row("GET", "/ctrl/${volume}", "", rws_system.volume_path),
    _Row("GET", F, F, rws_files.list_volumes),
    _Row("GET", *((f"{F}/{{path...}}",) * 2), rws_files.read_path),
    _Row("PUT", *((f"{F}/{{path...}}",) * 2), rws_files.store_file),
    _Row("DELETE", *((f"{F}/{{path...}}",) * 2), rws_files.delete_path),
    _Row("POST", f"{F}/{{path...}}", "", rws_files.act_on_path),
    _Row("POST", "", f"{F}/{{path...}}/create", rws_files.create_folder),
    _Row("POST", "", f"{F}/{{path...}}/copy", rws_files.copy_path),
    _Row("POST", "", f"{F}/{{path...}}/rename", rws_files.rename_path),
    _Row("GET", "/users/rmmp", "/users/rmmp", rws_system.privilege_status),
    _Row("POST", "/users/rmmp", "/users/rmmp", rws_system.request_privilege),
    _Row("GET", "/users/rmmp/poll", "/users/rmmp/poll", rws_system.poll_privilege_request),
    _Row("POST", "/users/rmmp?cancel", "/users/rmmp/cancel", rws_system.cancel_privilege),
    _Row("POST", "/users", "/users/register", rws_system.register_user),
    _Row("GET", "", "/users/login-info", rws_system.login_info),
)  # fmt: skip


_ROUTES: Final = {
    dialect: tuple(
        make_route(row.method, path, row.handler, row.needs)
        for row in _ROWS
        if (path := row.one if dialect == 1 else row.two)
    )
    for dialect in (1, 2)
}


def _serve_resource(cabinet: Cabinet, request: Request) -> Answer:
    """Finds the handler of a request and has it answer; raises Rejected."""
    found = find_route(_ROUTES[request.dialect], request)
    if isinstance(found, Rejected):
        raise found
    row, captures = found
    if row.needs:
        rws_system.check_mastership(cabinet, request, row.needs)
    return row.handler(cabinet, replace(request, captures=captures))


class Service:
    """Service of one cabinet; both dialects share it."""

    def __init__(self, cabinet: Cabinet, sessions: Sessions) -> None:
        self.cabinet, self.sessions = cabinet, sessions
        self.subscriptions = Subscriptions(cabinet)
        sessions.ended.append(self._ended)

    def __call__(self, request: Request) -> Answer:
        found = find_route(_OWN_ROUTES[request.dialect], request)
        try:
            if isinstance(found, Rejected):
                return _serve_resource(self.cabinet, request)
            row, captures = found
            return row.handler(self, replace(request, captures=captures))
        except (RuntimeError, TimeoutError):  # It is being switched off, or overwhelmed.
            raise Rejected(rws_messages.UNSPECIFIED, "the controller has no time") from None

    def _ended(self, session: Session) -> None:
        """Release the masterships and subscriptions of a session."""
        self.cabinet.mastership.give_back(MASTERSHIP_DOMAINS, session.key)
        self.subscriptions.end_session(session.key)


def _log_out(service: Service, request: Request) -> Answer:
    service.sessions.end(request.session)
    return Answer(200 if request.dialect == 1 else 204)


_OwnHandler = Callable[[Service, Request], Answer]
_BOTH: Final[tuple[tuple[str, str, _OwnHandler], ...]] = (
    ("GET", "/logout", _log_out),
    ("POST", "/subscription", lambda service, request: service.subscriptions.create(request)),
    (
        "DELETE",
        "/subscription/{group}",
        lambda service, request: service.subscriptions.delete(request),
    ),
)
_TWO: Final[tuple[tuple[str, str, _OwnHandler], ...]] = (
    ("PUT", "/subscription/{group}", lambda service, request: service.subscriptions.add(request)),
    (
        "DELETE",
        "/subscription/{group}/{resource...}",
        lambda service, request: service.subscriptions.delete(request),
    ),
)
_OWN_ROUTES: Final = {
    1: tuple(make_route(*row) for row in _BOTH),
    2: tuple(make_route(*row) for row in (*_BOTH, *_TWO)),
}


def make_service(cabinet: Cabinet, user: str, password: str) -> Service:
    """Return the service that both servers share."""
    return Service(cabinet, Sessions(user, password))


def make_server(
    dialect: int,
    place: tuple[str, int],
    service: Service,
    faults: Faults,
    certificate: FilePath | None,
) -> Server:
    """Not started yet. certificate: the file that is made for an encrypted one, None for plain.

    Raises OSError for the port.
    """
    secure = None if certificate is None else certify(place[0], certificate)
    site = Site(dialect, service.sessions, service, service.subscriptions.open, faults, secure)
    return Server(place, site)

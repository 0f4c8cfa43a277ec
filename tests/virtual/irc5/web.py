"""Robot Web Services through the standard library alone: Digest and Basic, cookies, TLS."""

from __future__ import annotations

import base64
import json
import re
import ssl
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass
from http.cookiejar import CookieJar
from typing import Any

FORM = "application/x-www-form-urlencoded"
HAL = "application/hal+json;v=2.0"
XHTML = "application/xhtml+xml;v=2.0"


@dataclass(frozen=True, slots=True)
class Answer:
    status: int
    headers: Any
    data: bytes

    @property
    def text(self) -> str:
        return self.data.decode()

    @property
    def json(self) -> Any:
        return json.loads(self.data)

    @property
    def code(self) -> int:
        """Of a refusal, in any of the forms."""
        found = re.search(r'"code": ?(-?\d+)|class="code">(-?\d+)', self.text)
        assert found, self.text
        return int(found[1] or found[2])

    def items(self, type: str | None = None) -> list[dict[str, Any]]:
        """What a JSON answer holds, in the shape of its dialect."""
        told = self.json
        rows = [
            *told.get("_embedded", {}).get("_state", []),
            *told.get("state", []),
            *told.get("_embedded", {}).get("resources", []),
        ]
        return [row for row in rows if type in (None, row["_type"])]

    def spans(self, type: str) -> list[dict[str, str]]:
        """What an XHTML answer holds."""
        rows = re.findall(rf'<li class="{type}" title="[^"]*">(.*?)</li>', self.text, re.DOTALL)
        return [dict(re.findall(r'<span class="([^"]+)"[^>]*>([^<]*)</span>', r)) for r in rows]


class One:
    """A client of RWS 1.0 that asks for JSON."""

    dialect = 1

    def __init__(self, controller, user: str | None = None, password: str | None = None) -> None:
        self.base = f"http://127.0.0.1:{controller.rws_port}"
        manager = urllib.request.HTTPPasswordMgrWithDefaultRealm()
        login = user or controller.user, password or controller.password
        manager.add_password(None, self.base, *login)
        self.cookies = CookieJar()
        self.opener = urllib.request.build_opener(
            urllib.request.ProxyHandler({}),
            urllib.request.HTTPDigestAuthHandler(manager),
            urllib.request.HTTPCookieProcessor(self.cookies),
        )

    def send(self, method, path, data=None, headers=None) -> Answer:
        asked = urllib.request.Request(
            self.base + path, method=method, data=data, headers=headers or {}
        )
        try:
            with self.opener.open(asked, timeout=10) as answer:
                return Answer(answer.status, answer.headers, answer.read())
        except urllib.error.HTTPError as wrong:
            with wrong:
                return Answer(wrong.code, wrong.headers, wrong.read())

    def get(self, path: str) -> Answer:
        return self.send("GET", path + ("&" if "?" in path else "?") + "json=1")

    def post(self, path: str, /, **form: str) -> Answer:
        """Fields with `-` in their names are written with `_`."""
        fields = {name.replace("_", "-"): value for name, value in form.items()}
        body = urllib.parse.urlencode(fields).encode()
        path += ("&" if "?" in path else "?") + "json=1"
        return self.send("POST", path, body, {"Content-Type": FORM})

    def put(self, path: str, data: bytes) -> Answer:
        return self.send("PUT", path, data, {"Content-Type": "application/octet-stream"})


class Two(One):
    """A client of RWS 2.0 that asks for HAL JSON."""

    dialect = 2

    def __init__(self, controller, user: str | None = None, password: str | None = None) -> None:
        self.base = f"https://127.0.0.1:{controller.rwss_port}"
        login = f"{user or controller.user}:{password or controller.password}"
        self.basic = "Basic " + base64.b64encode(login.encode()).decode()
        trusted = ssl.create_default_context(cafile=str(controller.certificate))
        self.cookies = CookieJar()
        self.opener = urllib.request.build_opener(
            urllib.request.ProxyHandler({}),
            urllib.request.HTTPSHandler(context=trusted),
            urllib.request.HTTPCookieProcessor(self.cookies),
        )

    def send(self, method, path, data=None, headers=None) -> Answer:
        usual = {"Authorization": self.basic, "Accept": HAL}
        return super().send(method, path, data, {**usual, **(headers or {})})

    def get(self, path: str) -> Answer:
        return self.send("GET", path)

    def post(self, path: str, /, **form: str) -> Answer:
        fields = {name.replace("_", "-"): value for name, value in form.items()}
        body = urllib.parse.urlencode(fields).encode()
        return self.send("POST", path, body, {"Content-Type": f"{FORM};v=2.0"})

    def put(self, path: str, data: bytes) -> Answer:
        return self.send("PUT", path, data, {"Content-Type": "text/plain;v=2.0"})


def wait_for(condition: Callable[[], bool], seconds: float = 10.0) -> None:
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, "it never came to be"
        time.sleep(0.01)


class Robot:
    """What tests do with either dialect: the paths of both, row by row."""

    def __init__(self, client: One) -> None:
        self.client = client

    def either(self, one: str, two: str) -> str:
        return one if self.client.dialect == 1 else two

    def post(self, one: str, two: str, /, **form: str) -> Answer:
        return self.client.post(self.either(one, two), **form)

    def file(self, name: str) -> str:
        return self.either(f"/fileservice/$HOME/{name}", f"/fileservice/HOME/{name}")

    def take(self, domain: str = "rapid") -> Answer:
        two = {"rapid": "edit", "cfg": "edit"}.get(domain, domain)
        return self.post(f"/rw/mastership/{domain}?action=request", f"/rw/mastership/{two}/request")

    def give_back(self, domain: str = "rapid") -> Answer:
        two = {"rapid": "edit", "cfg": "edit"}.get(domain, domain)
        return self.post(f"/rw/mastership/{domain}?action=release", f"/rw/mastership/{two}/release")

    def load(self, name: str, text: str, replace: str = "false") -> Answer:
        assert self.client.put(self.file(name), text.encode()).status in (200, 201)
        path = self.either(f"$HOME/{name}", f"HOME/{name}")
        return self.post(
            "/rw/rapid/tasks/T_ROB1?action=loadmod",
            "/rw/rapid/tasks/T_ROB1/loadmod",
            modulepath=path,
            replace=replace,
        )

    def motors(self, state: str = "motoron") -> Answer:
        return self.post(
            "/rw/panel/ctrlstate?action=setctrlstate", "/rw/panel/ctrl-state", ctrl_state=state
        )

    def execution(self, what: str, **form: str) -> Answer:
        one = f"/rw/rapid/execution?action={what}"
        return self.post(one, f"/rw/rapid/execution/{what}", **form)

    def state(self) -> str:
        return self.client.get("/rw/rapid/execution").items("rap-execution")[0]["ctrlexecstate"]

    def symbol(self, path: str) -> str:
        one, two = f"/rw/rapid/symbol/data/RAPID/{path}", f"/rw/rapid/symbol/RAPID/{path}/data"
        return self.either(one, two)

    def value(self, path: str) -> str:
        return self.client.get(self.symbol(path)).items("rap-data")[0]["value"]

    def set(self, path: str, value: str) -> Answer:
        return self.client.post(self.symbol(path) + self.either("?action=set", ""), value=value)

    def joints(self) -> list[float]:
        path = "/rw/motionsystem/mechunits/ROB_1/jointtarget"
        row = self.client.get(path).items("ms-jointtarget")[0]
        return [float(row[f"rax_{i}"]) for i in range(1, 7)]

    def codes(self) -> list[int]:
        """Of the events in the log, the oldest first."""
        found = [
            (int(row["_title"].rpartition("/")[2]), int(row["code"]))
            for row in self.client.get("/rw/elog/0?lang=en").items()
        ]
        return [code for _, code in sorted(found)]

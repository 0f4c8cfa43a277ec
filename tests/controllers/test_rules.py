"""The tables of findings of controllers, virtual controllers and deployment."""

import string

from assistant.base.diagnostics import Rule
from assistant.controllers import rules as controllers
from assistant.controllers.abb.exchange import rules as exchanging
from assistant.deploy import rules as deploying
from assistant.virtual.irc5 import controller as irc5
from assistant.virtual.irc5 import programs as irc5_modules
from assistant.virtual.irc5 import rws_faults as irc5_certificate

RULES = sorted(
    {
        rule
        for module in (controllers, exchanging, deploying, irc5, irc5_modules, irc5_certificate)
        for rule in vars(module).values()
        if isinstance(rule, Rule)
    },
    key=lambda rule: rule.code,
)
PLACES = {"path", "span", "line", "column", "place", "excerpt", "severity"}


def test_codes_are_unique():
    codes = [rule.code for rule in RULES]
    assert len(codes) == len(set(codes)) > 20
    assert {code[:2] for code in codes} == {"CN", "DP", "VC"}


def test_templates_name_no_field_that_is_a_place():
    fields = {
        rule.code: {name for _, name, _, _ in string.Formatter().parse(rule.message + rule.cure)}
        for rule in RULES
    }
    assert not {code: names & PLACES for code, names in fields.items() if names & PLACES}

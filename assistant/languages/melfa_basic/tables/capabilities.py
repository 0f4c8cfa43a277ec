"""What the dialects can say of what programs ask for."""

from __future__ import annotations

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.program.passes.legalising import Capabilities


def capabilities(dialect: Dialect) -> Capabilities:
    return Capabilities(
        functions=dialect.functions,
        most_dimensions=3,
        most_elements=999,  # of one dimension (COSIMIR help, Dim)
        cannot_say=rules.CANNOT_SAY,
        as_variables=rules.AS_VARIABLES,
        recursive=rules.RECURSIVE,
    )

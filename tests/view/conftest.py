"""The virtual controllers that pages follow."""

from tests.cli.conftest import cr, here

__all__ = ["cr", "here"]

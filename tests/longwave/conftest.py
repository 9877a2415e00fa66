"""Fixtures for commands that run in this process and whose output is compared."""

from collections.abc import Iterator

import pytest

from longwave.cli import statements


@pytest.fixture(scope="session", autouse=True)
def _slow_proofs_are_silent() -> Iterator[None]:
    """Disable the notice of slow proofs, which would depend on the load of the machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statements, "SECONDS_BEFORE_NOTICE", 600.0)
        yield

"""Commands in this process, of which what is printed is compared."""

from collections.abc import Iterator

import pytest

from longwave.cli import statements


@pytest.fixture(scope="session", autouse=True)
def _slow_proofs_are_silent() -> Iterator[None]:
    """They say after some seconds of the clock that they go on: on a loaded machine all do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statements, "SECONDS_BEFORE_NOTICE", 600.0)
        yield

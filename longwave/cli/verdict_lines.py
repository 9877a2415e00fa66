"""A file of verdicts, one JSON line each, written as they are reached and reused by later runs."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable
from dataclasses import asdict
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

from longwave.support.user_files import read_text, shown_path
from longwave.verify.proof.statement_verdict import StatementVerdict
from longwave.verify.proof.stored_verdict import checked_again, verdict_record
from longwave.verify.proof.typed_statement import Statement

MAX_BYTES = 1_000_000_000
"""Largest file of verdicts that is read, in bytes."""


class VerdictLines:
    """Verdicts reached within ``limit`` seconds each, stored in ``file``; none if it is None.

    A verdict is found by its statement's texts, the limit, and ``digest()`` of the sources. An
    entry is trusted as far as `checked_again` can check it. An incomplete line, as after a kill, is
    ignored.

    Raises ValueError for a file that others may write or that has no verdicts, and OSError if it
    cannot be opened.
    """

    def __init__(self, file: str | None, limit: float, digest: Callable[[], str]) -> None:
        self._path = None if file is None else Path(file)
        self._limit, self._digest = limit, digest
        self._records = {} if self._path is None else _read(self._path)

    def find(self, statement: Statement) -> StatementVerdict | None:
        """Return the stored verdict on a statement; None if there is none that can be trusted."""
        record = self._records.get(self._key(statement)) if self._records else None
        return None if record is None else checked_again(statement, record)

    def add(self, statement: Statement, verdict: StatementVerdict) -> None:
        """Append the verdict to the file."""
        if self._path is None:
            return
        line = json.dumps({"key": self._key(statement)} | verdict_record(verdict)) + "\n"
        descriptor = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
        with os.fdopen(descriptor, "a", encoding="utf-8") as stream:
            stream.write(line if self._is_whole else "\n" + line)
        self._is_whole = True

    @cached_property
    def _sources(self) -> str:
        return self._digest()

    def _key(self, statement: Statement) -> str:
        solved_for = list(map(str, statement.solve_for))
        parts = [asdict(statement.texts), solved_for, statement.weak, self._limit, self._sources]
        return sha256(json.dumps(parts).encode()).hexdigest()

    @cached_property
    def _is_whole(self) -> bool:
        """Whether the file is empty or ends with a line break."""
        assert self._path is not None
        try:
            with self._path.open("rb") as stream:
                stream.seek(-1, os.SEEK_END)
                return stream.read() == b"\n"
        except OSError:  # missing or empty
            return True


def _read(path: Path) -> dict[str, Any]:
    def check(state: os.stat_result) -> None:
        if state.st_uid != os.geteuid() or state.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            got = f"{shown_path(path)} (chmod go-w, or name a new one)"
            raise ValueError(f"--lines must be a file that nobody else may write, got {got}")

    try:
        text = read_text(path, "--lines", MAX_BYTES, check)
    except FileNotFoundError:
        return {}
    records = {}
    for line in text.splitlines():
        try:
            record = json.loads(line)
            records[record["key"]] = record
        except (ValueError, TypeError, KeyError, RecursionError):
            continue
    if text and not records:
        got = f"{shown_path(path)}, which has none (take another name)"
        raise ValueError(f"--lines must name a file of verdicts or a new one, got {got}")
    return records

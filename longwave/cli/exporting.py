"""``longwave prove ... --export SYSTEM``: certificates as scripts of other systems."""

from __future__ import annotations

import glob
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from longwave.support.atomic_file import write_atomically
from longwave.support.console import check_output
from longwave.verify.proof.export.derivation import written_out
from longwave.verify.proof.export.systems import SYSTEMS
from longwave.verify.proof.export.terms import premises_in_short


@dataclass(frozen=True)
class Scripts:
    """Scripts for a ``system``, to be written to ``output``; several get a number each."""

    output: str
    system: str
    force: bool = False

    def check(self, read: Sequence[str | Path] = ()) -> None:
        """Raise ValueError, before the work, if they cannot or may not be written.

        What is ``read`` is never overwritten.
        """
        check_output(self.output, "proof.v", force=self.force, read=read)
        path = Path(self.output)
        others = sorted(path.parent.glob(f"{glob.escape(path.stem)}_[0-9]*{path.suffix}"))
        if others and not self.force:
            raise ValueError(
                f"--output must name new files, got {self.output} beside {others[0].name}, "
                "which is there (--force overwrites it)"
            )

    def write(self, certificates: Sequence[Mapping[str, Any]]) -> list[Path]:
        """Write a script for each certificate, and tell its premises on the standard error.

        Raises CertificateError for one that has no script, ValueError where there is none, OSError
        as writing does.
        """
        if not certificates:
            raise ValueError(
                "--export must be given with what is proved, got no proof (see verdict)"
            )
        proofs = [written_out(certificate) for certificate in certificates]
        texts = [SYSTEMS[self.system].write(proof) for proof in proofs]
        paths = [path := Path(self.output)]
        if len(texts) > 1:
            paths = [path.with_stem(f"{path.stem}_{number}") for number in range(1, len(texts) + 1)]
        for file, text, proof in zip(paths, texts, proofs, strict=True):
            write_text(file, text, self.force)
            if proof.premises:
                conditions = premises_in_short(proof.conditions)
                print(f"{file}: accepted will mean proved if {conditions}", file=sys.stderr)
        return paths


def write_text(path: Path, text: str, force: bool) -> None:
    """Write a file whole or not at all; without ``force`` none is overwritten."""
    write_atomically(path, lambda draft: draft.write_text(text, encoding="utf-8"), force)

"""The file that proofs are written to, as certificates or as scripts of other systems."""

from __future__ import annotations

import glob
import json
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
class ProofFile:
    """The file ``output`` of proofs: their certificates or, for a ``system``, a script of each.

    Several scripts get a number each. Without ``output`` nothing is written.
    """

    output: str | None
    system: str | None = None
    force: bool = False

    def check(self, read: Sequence[str | Path] = ()) -> None:
        """Raise ValueError, before the work, if it cannot or may not be written.

        What is ``read`` is never overwritten.
        """
        if self.output is None:
            if self.system is not None:
                raise ValueError("--export must be given with --output FILE, got no file")
            return
        example = "c.json" if self.system is None else "proof.v"
        check_output(self.output, example, force=self.force, read=read)
        path = Path(self.output)
        others = sorted(path.parent.glob(f"{glob.escape(path.stem)}_[0-9]*{path.suffix}"))
        if self.system is not None and others and not self.force:
            raise ValueError(
                f"--output must name new files, got {self.output} beside {others[0].name}, "
                "which is there (--force overwrites it)"
            )

    def write(self, certificates: Sequence[Mapping[str, Any]]) -> None:
        """Write what is proved; of scripts, tell the premises on the standard error.

        Raises CertificateError for a proof that has no script, ValueError for scripts of none,
        OSError as writing does.
        """
        if self.output is None:
            return
        path = Path(self.output)
        if self.system is None:
            texts = [json.dumps(certificate) for certificate in certificates]
            self._write(path, "[" + ",\n".join(texts) + "]\n")
            return
        if not certificates:
            raise ValueError(
                "--export must be given with what is proved, got no proof (see verdict)"
            )
        proofs = [written_out(certificate) for certificate in certificates]
        texts = [SYSTEMS[self.system].write(proof) for proof in proofs]
        for number, (text, proof) in enumerate(zip(texts, proofs, strict=True), 1):
            file = path if len(texts) == 1 else path.with_stem(f"{path.stem}_{number}")
            self._write(file, text)
            if proof.premises:
                conditions = premises_in_short(proof.conditions)
                print(f"{file}: accepted will mean proved if {conditions}", file=sys.stderr)

    def _write(self, path: Path, text: str) -> None:
        write_atomically(path, lambda draft: draft.write_text(text, encoding="utf-8"), self.force)

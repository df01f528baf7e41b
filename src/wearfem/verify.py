"""Prove on this machine what is claimed: run proofs, print each claim beside its source, write them down."""

import importlib
import pkgutil
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import wearfem.proofs
from wearfem.errors import UserError, in_words
from wearfem.progress import clock
from wearfem.proof import Claim
from wearfem.record import require_writable, this_machine, write_json


def proof_names() -> list[str]:
    """The names of all proofs: the modules of `wearfem.proofs` that do not begin with an underscore."""
    names = (module.name for module in pkgutil.iter_modules(wearfem.proofs.__path__))
    return sorted(name for name in names if not name.startswith("_"))


def verify(names: Sequence[str] = (), json_file: Path | None = None) -> bool:
    """Run proofs and print their claims as they are settled.

    Parameters
    ----------
    names
        Of the proofs to run; all without it.
    json_file
        Where to write the claims too, with the versions that gave them.

    Returns
    -------
    bool
        Whether every claim holds.
    """
    known = proof_names()
    unknown = [name for name in names if name not in known]
    if unknown:
        raise UserError(f"there is no proof {in_words(unknown, 'or')}: the proofs are {in_words(known)}")
    if json_file:
        require_writable(json_file)
    settled: list[dict[str, Any]] = []
    for name in dict.fromkeys(names or known):
        settled.extend(_run(name))
    failed = sum(not row["holds"] for row in settled)
    shown = sum(row["verdict"] == "shown" for row in settled)
    print(
        f"\n{len(settled) - failed - shown} claims hold, {failed} fail, {shown} are shown without judgement"
    )
    if json_file:
        write_json(json_file, this_machine() | {"claims": settled})
        print(f"wrote {json_file}")
    return failed == 0


def _run(name: str) -> list[dict[str, Any]]:
    """Run one proof; its claims as plain values."""
    proof = importlib.import_module(f"wearfem.proofs.{name}")
    print(f"\n{name}: {(proof.__doc__ or '').strip().splitlines()[0]}", flush=True)
    settled, started = [], time.monotonic()
    for claim in proof.claims():
        print("\n".join(claim_lines(claim)), flush=True)
        settled.append({"proof": name} | asdict(claim) | {"holds": claim.holds, "verdict": claim.verdict})
    print(f"  {len(settled)} claims in {clock(time.monotonic() - started)}", flush=True)
    return settled


def claim_lines(claim: Claim) -> list[str]:
    """A claim as lines of text: verdict, words and numbers, then its source and its note."""
    unit = "" if claim.unit == "-" else f" {claim.unit}"
    numbers = f"expected {claim.expected:.7g}{unit}, computed {claim.computed:.7g}{unit}"
    if claim.tolerance == float("inf"):
        allowed = "not judged"
    else:
        allowed = f"tolerance {claim.tolerance:g}{' relative' if claim.relative else unit}"
    off = f"off by {claim.difference:.2g}{' relative' if claim.relative else unit}"
    lines = [f"  {claim.verdict}  {claim.claim}", f"         {numbers}, {off}, {allowed}"]
    lines.append(f"         source: {claim.source}")
    if claim.note:
        lines.append(f"         note: {claim.note}")
    return lines

"""The proof `remeshing`: every claim of it holds, with the tolerances and their reasons given there."""

from wearfem.proofs.remeshing import claims


def test_every_claim_holds():
    failed = [f"{claim.claim}: {claim.difference:.3g}" for claim in claims() if not claim.holds]
    assert not failed

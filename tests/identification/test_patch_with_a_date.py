"""Material that sticks from some day on: found with its day, by readings that another equation made."""

import numpy as np
import pytest

from wearfem.survey.candidates import candidates
from wearfem.survey.history import Model, depths
from wearfem.survey.identify import fit, readings
from wearfem.survey.survey import read_survey
from wearfem.wear.effects import BuildUp

CENTRE, RADIUS, RATIO, SINCE, RATE = (1.1, 0.1), 0.3, 0.2, 330.0, 0.012  # m, m, -, kt, mm/kt
TONNAGE = (120.0, 260.0, 400.0, 520.0, 700.0, 830.0)


def plate(folder, gauge):
    """Straight lines that bend at one tonnage, inside the patch: no march, no factor"""
    random = np.random.default_rng(11)
    place = np.stack([random.uniform(0.0, 2.0, 40), random.uniform(-0.5, 0.5, 40)], axis=1)
    inside = np.linalg.norm(place - CENTRE, axis=1) < RADIUS
    rows = ["point,occasion,tonnage_kt,depth_mm,sigma_mm,x_m,y_m,z_m"]
    for j, t in enumerate(TONNAGE):
        worn = RATE * np.where(inside & (t > SINCE), SINCE + RATIO * (t - SINCE), t)
        read = worn + gauge * random.normal(size=40)
        rows += [
            f"{i},{j + 1},{t},{read[i]:.9f},{max(gauge, 1e-3)},{place[i, 0]:.6f},{place[i, 1]:.6f},0"
            for i in range(40)
        ]
    folder.mkdir()
    (folder / "survey.csv").write_text("\n".join(rows) + "\n")
    return readings(read_survey(folder / "survey.csv"))


def test_the_depth_bends_within_an_interval(tmp_path):
    data = plate(tmp_path / "plate", 0.0)
    patch = BuildUp((*CENTRE, 0.0), RADIUS, RATIO, SINCE)
    wear = data.past.of_rows(depths(data.past, Model(1e-3 * RATE, (patch,))))
    assert wear == pytest.approx(data.worn, abs=2e-12)  # as written: nine digits of a millimetre


def test_a_patch_is_found_with_its_day(tmp_path):
    data = plate(tmp_path / "plate", 0.1)
    suspect = next(one for one in candidates(data.past, data.deepest) if one.name == "BuildUp")
    found, plain = fit(data, [suspect]), fit(data)
    (patch,) = found.model.effects
    deviation = np.sqrt(np.diag(found.deviation))[1:3]
    ends = suspect.effect(found.coordinate[1:] + [*(2.0 * deviation), 0.0])
    assert patch.ratio == pytest.approx(RATIO, abs=abs(ends.ratio - patch.ratio))  # two standard errors each
    assert patch.since == pytest.approx(SINCE, abs=abs(ends.since - patch.since))
    assert abs(ends.since - patch.since) < 60.0  # [kt] half an interval: it does know
    assert found.log_evidence > plain.log_evidence + 20.0

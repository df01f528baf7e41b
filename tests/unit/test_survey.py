"""Reading surveys: units from names, plates replaced, holes, and refusals in one sentence."""

import numpy as np
import pytest

from wearfem.errors import UserError
from wearfem.survey.calibrate import calibrate
from wearfem.survey.columns import column
from wearfem.survey.doubt import doubted
from wearfem.survey.history import history
from wearfem.survey.identify import readings
from wearfem.survey.survey import read_survey


def written(tmp_path, text, name="survey.csv"):
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("name", "quantity", "number", "si"),
    [
        ("thickness_mm", "thickness", 12.0, 0.012),
        ("speed_m_s", "speed", 2.0, 2.0),
        ("temperature_c", "temperature", 20.0, 293.15),
        ("ore_hardness_hv", "ore_hardness", 1000.0, 9.80665e9),
        ("impact_angle_deg", "impact_angle", 180.0, np.pi),
        ("volume_loss_mm3", "volume_loss", 1.0, 1e-9),
        ("days", "days", 1.0, 86400.0),
        ("roughness", "roughness", 3.0, 3.0),
    ],
)
def test_a_name_tells_the_unit(name, quantity, number, si):
    told = column(name)
    assert told.quantity == quantity
    assert told.si(np.array(number)) == pytest.approx(si, rel=1e-15)  # products of two numbers


def test_thickness_becomes_wear_and_negative_wear_is_data(tmp_path):
    rows = ["point,occasion,tonnage_kt,thickness_mm"]
    rows += [
        f"{p},{o},{o * 10},{20 - 0.1 * o * p + (0.3 if (p, o) == (2, 3) else 0)}"
        for p in (1, 2, 3)
        for o in range(5)
    ]
    data = readings(read_survey(written(tmp_path, "\n".join(rows))))
    assert data.thickness_free
    assert data.worn[4] == pytest.approx(0.4e-3, abs=1e-12)  # rounding
    assert data.worn[8] < data.worn[7]  # point 2 reads thicker at the third occasion than before


def test_a_plate_that_was_replaced_starts_anew(tmp_path):
    rows = ["point,occasion,tonnage_kt,depth_mm,specimen"]
    rows += ["A,1,10,1.0,first", "A,2,20,2.0,first", "A,3,30,1.0,second", "A,4,40,2.0,second"]
    survey = read_survey(written(tmp_path, "\n".join(rows)))
    assert survey.life_start.tolist() == [0.0, 20.0]
    past = history(survey)
    assert past.begin[1, 0] == 20.0
    rows = ["point,occasion,time_h,depth_mm,specimen", "A,1,1,1,a", "A,2,2,2,a", "A,1,1,1,b", "A,2,2,2,b"]
    side_by_side = read_survey(written(tmp_path, "\n".join(rows)))
    assert side_by_side.life_start.tolist() == [0.0, 0.0]


def test_a_missing_reading_takes_the_log_of_its_occasion(tmp_path):
    rows = ["point,occasion,tonnage_kt,depth_mm,temperature_c"]
    rows += [f"{p},{o},{10 * o},{o},{5 * o}" for p in "ABC" for o in (1, 2, 3) if (p, o) != ("B", 2)]
    past = history(read_survey(written(tmp_path, "\n".join(rows))))
    assert past.feature["temperature"][1] == pytest.approx([278.15, 283.15, 288.15])
    assert past.end[1].tolist() == [10.0, 20.0, 30.0]


def test_exposure_comes_from_a_table_or_from_rows(tmp_path):
    survey = written(tmp_path, "point,occasion,tonnage_kt,depth_mm\nA,1,1,1\nB,1,1,2\n")
    table = written(tmp_path, "point,exposure,pressure_kpa\nB,2.0,3\nA,1.0,4\n", "exposure.csv")
    read = read_survey(survey, exposure=table)
    assert read.exposure.tolist() == [1.0, 2.0]
    assert read.feature["pressure"].tolist() == [4000.0, 3000.0]
    rows = written(tmp_path, "point,occasion,tonnage_kt,depth_mm,exposure\nA,1,1,1,3\nB,1,1,2,4\n")
    assert read_survey(rows).exposure.tolist() == [3.0, 4.0]


GOOD = "point,occasion,tonnage_kt,depth_mm\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no rows"),
        ("place,tonnage_kt,depth_mm\n1,2,3\n", "no column point"),
        ("point,occasion,depth_mm\n1,1,3\n", "counts service"),
        ("point,occasion,tonnage_kt,time_h,depth_mm,thickness_mm\n1,1,1,1,3,4\n", "exactly one"),
        ("point,occasion,tonnage_kt,depth\n1,1,1,3\n", "without unit"),
        (GOOD + "1,1,1,three\n", "'three'"),
        (GOOD + "1,1,1,\n", "no value"),
        (GOOD + "1,1,-1,2\n", "below 0"),
        (GOOD + "1,1,1\n", "3 values"),
        (GOOD + "1,1,1,2,5\n", "5 values; the header names 4 columns; a decimal has a point"),
        (GOOD + ",1,1,2\n", "no point in data row 1"),
        (GOOD + "1,,1,2\n", "no occasion in data row 1"),
        (GOOD.replace(",", ";") + "1;1;1,5;2,5\n", "values by semicolons"),
        (GOOD.replace(",", "\t") + "1\t1\t1.5\t2.5\n", "values by tabs"),
        ("point,occasion,tonnage_kt,depth_mm,sigma_mm\n1,1,1,2,0\n", "sigma of 0"),
        ("point,occasion,tonnage_kt,depth_mm,exposure\n1,1,1,2,-1\n", "exposures below 0"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_sentence(tmp_path, text, says):
    with pytest.raises(UserError, match=says):
        read_survey(written(tmp_path, text))


@pytest.mark.parametrize(("coding", "byte"), [("latin-1", "0xfc"), ("utf-16", "0xff")])
def test_a_file_in_another_coding_is_refused_in_a_sentence(tmp_path, coding, byte):
    path = tmp_path / "survey.csv"
    path.write_text(GOOD + "Mühle,1,1,2\n", encoding=coding)
    with pytest.raises(UserError, match=f"not text in UTF-8 .*{byte}"):
        read_survey(path)


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_what_spreadsheets_write_is_read(tmp_path, newline):
    """With a byte order mark, any end of a line, blanks around commas, capitals in names, quotes."""
    text = 'Point, Occasion ,TONNAGE_kt,depth_mm\n"Mühle, oben",1, 1 ,"2.5"\n"Mühle, oben",2,2,3.5\n'
    path = tmp_path / "survey.csv"
    path.write_text(text, encoding="utf-8-sig", newline=newline)
    read = read_survey(path)
    assert read.point_names == ("Mühle, oben",)
    assert read.reading.tolist() == [2.5e-3, 3.5e-3]


def test_a_folder_is_no_table_of_exposures(tmp_path):
    survey = written(tmp_path, GOOD + "1,1,1,2\n")
    with pytest.raises(UserError, match="is a folder; .*in it: .*csv"):
        read_survey(survey, exposure=tmp_path)


def plain_survey(tmp_path, wrong=0.0, seed=1, k=2e-3):
    rng = np.random.default_rng(seed)
    rows = ["point,occasion,tonnage_kt,depth_mm,sigma_mm,exposure"]
    for p in range(15):
        exposure = 1.0 + 0.2 * p
        for o in range(1, 7):
            depth = k * exposure * 100 * o + rng.normal(0, 0.02) + (wrong if (p, o) == (7, 3) else 0.0)
            rows.append(f"P{p},{o},{100 * o},{depth:.5f},0.02,{exposure}")
    return read_survey(written(tmp_path, "\n".join(rows)))


def test_the_coefficient_and_its_interval(tmp_path):
    inside = []
    for seed in range(20):
        found = calibrate(plain_survey(tmp_path, seed=seed))
        inside.append(found.interval[0] < 2e-6 < found.interval[1])
        assert found.coefficient == pytest.approx(
            2e-6, rel=0.005
        )  # 5 standard errors of 90 readings of 0.02 mm
    assert sum(inside) >= 15  # 90 % intervals: of 20, fewer than 15 in 1 of 90 trials


def test_a_wrong_reading_is_doubted_and_does_not_move_the_coefficient(tmp_path):
    right, wrong = calibrate(plain_survey(tmp_path)), calibrate(plain_survey(tmp_path, wrong=2.0))
    assert [(d.point, d.occasion) for d in wrong.doubts] == [("P7", "3")]
    assert not right.doubts
    step = right.interval[1] - right.interval[0]
    assert abs(wrong.coefficient - right.coefficient) < 0.25 * step  # one reading of 90 less


def test_a_change_of_rate_is_not_doubted(tmp_path):
    rows = [GOOD.strip()]
    rows += [
        f"P{p},{o},{o},{min(o, 4) * (1 + 0.1 * p) + 0.01 * ((p * 7 + o * 3) % 5)}"
        for p in range(6)
        for o in range(1, 9)
    ]
    assert doubted(read_survey(written(tmp_path, "\n".join(rows)))) == ()


def test_a_plate_whose_wear_vanishes_is_taken_as_replaced(tmp_path):
    rows = [GOOD.strip().replace("depth", "thickness")]
    for p in range(4):
        for o in range(9):
            worn = 0.5 * (o - 5 if p == 3 and o >= 5 else o) + 0.01 * ((p * 7 + o * 3) % 5)
            rows.append(f"P{p},{o},{o},{20 - worn}")
    survey = read_survey(written(tmp_path, "\n".join(rows)))
    assert survey.taken_as_replaced == ("P3",)
    assert survey.life_start.tolist() == [0, 0, 0, 0, 4]


def test_a_survey_without_wear_is_refused(tmp_path):
    survey = read_survey(written(tmp_path, GOOD + "A,1,10,0\nA,2,20,0\n"))
    with pytest.raises(UserError, match="shows no wear"):
        calibrate(survey)


def test_a_folder_is_told_what_a_survey_is(tmp_path):
    with pytest.raises(
        UserError,
        match="is a folder, and a survey is a CSV file, one row a reading: .* no CSV file lies in it",
    ):
        read_survey(tmp_path)
    (tmp_path / "measured").mkdir()
    for number in range(8):
        written(tmp_path / "measured", GOOD, f"s{number}.csv")
    with pytest.raises(
        UserError, match=r"in it: measured/s0.csv, .*measured/s5.csv and 2 more\. Give a survey"
    ):
        read_survey(tmp_path)

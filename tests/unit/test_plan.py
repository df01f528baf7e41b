"""The words of a study, and the rows that they make."""

import pytest

from wearfem.errors import UserError
from wearfem.plan import Range, grid, latin, listed, parse_ranges, parse_values, sobol


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("mesh=8,6,4*mm", (0.008, 0.006, 0.004)),
        ("feed=900,1000*tonne/hour", (250.0, 1000e3 / 3600.0)),
        ("mesh=8*mm,6e-3,4*mm", (0.008, 6e-6, 0.004)),  # 6e-3 has no unit, so it takes mm like the 6 above
        ("count=1,2,3", (1, 2, 3)),
        ("x=1*kN,2", (1000.0, 2)),  # the last has none: nothing is carried over
        ("law=constant,running_in", ("constant", "running_in")),
        ("size=(1,2),(3,4)", ((1, 2), (3, 4))),
        ("size=(1,2)", ((1, 2),)),
        ("x=(1+2)*mm,4*mm", (0.003, 0.004)),
    ],
)
def test_values(text, values):
    ((_, found),) = parse_values([text]).items()
    assert found == pytest.approx(values, rel=1e-15) if isinstance(values[0], float) else found == values


def test_ranges():
    found = parse_ranges(["mesh=4..8*mm", "law=a,b", "temperature=-20..40"])
    assert found == {"mesh": Range(0.004, 0.008), "law": ("a", "b"), "temperature": Range(-20, 40)}


def test_a_grid_is_every_combination_and_a_list_goes_side_by_side():
    values = {"a": (1, 2), "b": (3, 4)}
    assert grid(values) == ({"a": 1, "b": 3}, {"a": 1, "b": 4}, {"a": 2, "b": 3}, {"a": 2, "b": 4})
    assert listed(values) == ({"a": 1, "b": 3}, {"a": 2, "b": 4})
    assert listed({"a": (1, 2), "b": (3,)}) == ({"a": 1, "b": 3}, {"a": 2, "b": 3})


@pytest.mark.parametrize("spread", [sobol, latin])
def test_points(spread):
    rows = spread({"a": Range(1.0, 2.0), "n": Range(2, 5), "law": ("x", "y")}, 16, seed=1, whole=["n"])
    assert rows == spread(
        {"a": Range(1.0, 2.0), "n": Range(2, 5), "law": ("x", "y")}, 16, seed=1, whole=["n"]
    )
    assert all(1.0 <= row["a"] <= 2.0 for row in rows)
    assert {row["n"] for row in rows} == {2, 3, 4, 5}
    assert all(isinstance(row["n"], int) for row in rows)
    assert sum(row["law"] == "x" for row in rows) == 8  # of 16: each of two as often


@pytest.mark.parametrize(
    ("work", "sentence"),
    [
        (lambda: parse_values(["mesh"]), "needs KEYWORD=VALUES"),
        (lambda: parse_values(["mesh=1", "mesh=2"]), "given mesh twice"),
        (lambda: parse_values(["mesh=8,6,4*mmm"]), "mmm is not a unit"),
        (lambda: parse_values(["mesh=8,,4"]), "cannot be read"),
        (lambda: parse_ranges(["mesh=8.."]), "cannot be read|two numbers"),
        (lambda: parse_ranges(["mesh=a..b"]), "a range needs two numbers"),
        (lambda: parse_ranges(["mesh=8..4*mm"]), "the second must be the larger"),
        (lambda: grid({}), "no keyword to vary"),
        (lambda: listed({"a": (1, 2, 3), "b": (1, 2)}), "another number of b"),
        (lambda: sobol({"a": Range(0, 1)}, 12), "power of 2"),
        (lambda: latin({"a": Range(0, 1)}, 0), "1 or more"),
    ],
)
def test_mistakes_are_sentences(work, sentence):
    with pytest.raises(UserError, match=sentence):
        work()

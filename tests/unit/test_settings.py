"""`--set`: arithmetic with units, and a sentence for everything else."""

import inspect
import math
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wearfem.errors import UserError
from wearfem.settings import check_settings, parse_settings, parse_value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("900*tonne/hour", 250.0),
        ("3.5*mm", 0.0035),
        ("-(1 + 2)*2**3", -24.0),
        ("65*GPa", 65e9),
        ("60*rpm", 2 * math.pi),
        ("180*degree", math.pi),
        ("955*kt", 955e6),
        ("0.01*percent", 1e-4),
        ("7", 7),
        ("full", "full"),
        ("'four words, in quotes'", "four words, in quotes"),
        ("chute.msh", "chute.msh"),
        ("true", True),
        ("False", False),
        ("8*mm, 6*mm", (0.008, 0.006)),
    ],
)
def test_a_value_is_what_it_says(text, value):
    parsed = parse_value("k", text)
    assert parsed == pytest.approx(value, rel=1e-15) if isinstance(value, float) else parsed == value


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("throughput", "needs KEYWORD=VALUE"),
        ("=5", "needs KEYWORD=VALUE"),
        ("k=", "needs KEYWORD=VALUE"),
        ("my key=5", "needs KEYWORD=VALUE"),
        ("k=5*tone", r"did you mean tonne"),
        ("k=5*", "cannot be read"),
        ("k=4mm", r"as in 4\*mm"),
        ("k==5", "cannot be read"),
        ("k=1/0", "divides by zero"),
        ("k=9**9**9", "too large"),
        ("k=1e999", "not a finite real number"),
        ("k=(-8)**0.5", "not a finite real number"),
        ("k=__import__('os').system('true')", "not allowed"),
        ("k=[1 for _ in 'ab']", "not allowed"),
        ("k=2*true", "true is not a unit"),
        ("k=2*True", "not allowed"),
        ("k=" + "(" * 5000, "cannot be read"),
        ("k=" + "-" * 100000 + "1", "cannot be read"),
    ],
)
def test_nonsense_is_refused_in_one_sentence(text, expected):
    with pytest.raises(UserError, match=expected) as caught:
        parse_settings([text])
    assert "\n" not in str(caught.value)


def test_a_keyword_given_twice_is_refused():
    with pytest.raises(UserError, match="force twice"):
        parse_settings(["force=5", "force=6"])


@given(st.text(max_size=30))
def test_any_text_is_a_value_or_a_sentence(text):
    try:
        parse_settings([f"k={text}"])
    except UserError as error:
        assert str(error)


def case(
    *,
    force: float = 5.0,
    seed: int = 1,
    held: bool = True,
    resolution: Literal["full", "demo"] = "full",
    title="a",
    sizes=(0.003, 0.008),
): ...


SIGNATURE = inspect.signature(case)


def test_settings_replace_defaults_and_take_their_kind():
    resolved = check_settings({"force": 6, "seed": 1e3, "sizes": 0.004}, SIGNATURE, "demo")
    assert resolved == {
        "force": 6.0,
        "seed": 1000,
        "held": True,
        "resolution": "full",
        "title": "a",
        "sizes": (0.004,),
    }
    assert isinstance(resolved["force"], float)
    assert isinstance(resolved["seed"], int)


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (
            {"forse": 6.0},
            r"no keyword forse \(did you mean force\?\); its keywords are, in SI, force=5, seed=1, held",
        ),
        ({"force": "tone"}, "a number in SI.*did you mean tonne"),
        ({"force": True}, "a number in SI"),
        ({"seed": 1.5}, "a whole number"),
        ({"held": 1}, "true or false"),
        ({"title": 3.0}, "a word"),
        ({"resolution": "fine"}, "it can be full or demo"),
    ],
)
def test_settings_that_do_not_fit_the_case_are_refused(settings, expected):
    with pytest.raises(UserError, match=expected):
        check_settings(settings, SIGNATURE, "demo")

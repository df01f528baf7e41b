"""The course of a run by the service in which the case alone would have walked it: closed forms."""

import numpy as np
import pytest

from wearfem.survey.course import Course, at_own_pace

PROGRESS = np.linspace(0.0, 10.0, 401)


def course(rate):
    rate = np.atleast_2d(rate)
    return Course(PROGRESS, rate, {"pressure": 10.0 * rate}, np.zeros((len(rate), 3)), True)


def test_an_even_pace_stretches_the_clock():
    plain = course(1.0 + 0.1 * PROGRESS)
    own = at_own_pace(plain, np.full((1, len(PROGRESS)), 2.0))
    at = np.array([[1.0, 7.0, 19.0]])
    # straight rates stay straight, so both integrals are exact: depth by twice the service is twice the depth
    np.testing.assert_allclose(own.depth_at(at), 2.0 * plain.depth_at(0.5 * at), rtol=1e-12)
    np.testing.assert_allclose(
        own.state_at("pressure", at / 2), plain.state_at("pressure", at / 2), rtol=1e-12
    )


def test_a_run_is_found_again_along_its_own_course():
    """Wear d' = p(t) E with E = 1/(1 + d) and p = 1 + t/5: (1 + d)^2 = 1 + 2 S with S = t + t^2/10"""
    pace = 1.0 + PROGRESS / 5.0
    depth = np.sqrt(1.0 + 2.0 * (PROGRESS + PROGRESS**2 / 10.0)) - 1.0
    own = at_own_pace(course(1.0 / (1.0 + depth)), pace[None, :])
    walked = np.array([[3.0, 11.0, 19.5]])  # S
    # trapezoids: h^3 E'' / 12 in sum, 1e-5 for 400 of them
    np.testing.assert_allclose(own.depth_at(walked), np.sqrt(1.0 + 2.0 * walked) - 1.0, rtol=5e-5)
    # states go by the service of the run, not by S
    at = PROGRESS[None, 50:90:10]
    np.testing.assert_allclose(own.state_at("pressure", at), 10.0 / (1.0 + depth[None, 50:90:10]), rtol=1e-12)


def test_lives_have_their_own_pace():
    two = at_own_pace(
        course(np.ones((2, len(PROGRESS)))), np.stack([np.ones(len(PROGRESS)), 3.0 + 0.0 * PROGRESS])
    )
    np.testing.assert_allclose(two.depth_at(np.array([[6.0], [6.0]])), [[6.0], [6.0]], rtol=1e-13)
    assert two.state_at("pressure", np.array([[9.0], [9.0]])).tolist() == [[10.0], [10.0]]
    # beyond its last sample a life goes on at its last pace
    assert two.service[0, -1] == pytest.approx(30.0)
    assert two.service[1, -1] == pytest.approx(10.0)

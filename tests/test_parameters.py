"""Table 2, and what the parameters refuse."""

import dataclasses
import json
import math
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from tests.strategies import examples

PER_LEG = ("leg_mass", "servo_mass", "leg_length")
POSITIVE = (*PER_LEG, "battery_mass", "shell_radius", "hip_offset")
UNITS = {
    "mass": "kg",
    "length": "m",
    "radius": "m",
    "offset": "m",
    "gravity": "m/s^2",
    "damping": "N m s/rad",
}


def make(name: str, value: Any) -> rr.RRRobotParameters:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rr.GroundClearanceWarning)
        return rr.RRRobotParameters(**{name: value})


def test_defaults_are_table_2():
    p = rr.RRRobotParameters()
    table = {"leg_mass": 0.057, "servo_mass": 0.053, "battery_mass": 0.3, "shell_radius": 0.12,
             "leg_length": 0.1, "hip_offset": 0.12, "gravity": 9.81, "damping": 0.01}  # fmt: skip
    assert p.to_dict() == table
    assert p.total_mass == pytest.approx(0.52, abs=1e-15)
    assert p.ground_clearance == pytest.approx(0.02, abs=1e-15)
    assert (p.leg_masses, p.servo_masses, p.leg_lengths) == ((0.057,) * 2, (0.053,) * 2, (0.1,) * 2)


@pytest.mark.parametrize("value", [-0.1, -math.inf, math.inf, math.nan])
@pytest.mark.parametrize("name", [*POSITIVE, "gravity", "damping"])
def test_out_of_range(name, value):
    with pytest.raises(rr.ParameterError) as caught:
        make(name, value)
    rule = "at least zero" if name in ("gravity", "damping") else "greater than zero"
    unit = UNITS[name.rsplit("_", maxsplit=1)[-1]]
    assert str(caught.value) == f"{name} is {value!r} {unit}: it must be {rule} and finite."
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("name", POSITIVE)
def test_zero_is_no_mass_and_no_length(name):
    with pytest.raises(rr.ParameterError, match=rf"^{name} is 0\.0 .*greater than zero"):
        make(name, 0)


def test_no_gravity_is_allowed():
    assert rr.RRRobotParameters(gravity=0).gravity == 0.0


NOT_NUMBERS: list[Any] = ["0.1", "", True, np.True_, np.str_("0.1"), None, 1j, np.complex128(1),
                          {"a": 1}, {0.1}, b"1", np.array("0.1")]  # fmt: skip


@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
@pytest.mark.parametrize("name", ["leg_mass", "battery_mass", "gravity"])
def test_not_a_number(name, value):
    with pytest.raises(rr.ParameterError, match=rf"^{name} is .*: it must be a number"):
        make(name, value)


@pytest.mark.parametrize("name", [*POSITIVE, "gravity", "damping"])
def test_too_large_for_a_float(name):
    with pytest.raises(rr.ParameterError, match=rf"^{name} is too large.*finite"):
        make(name, 10**400)


@pytest.mark.parametrize("value", [(), (0.1,), (0.1, 0.1, 0.1), [0.1] * 4, np.full(3, 0.1)])
@pytest.mark.parametrize("name", PER_LEG)
def test_pair_of_the_wrong_size(name, value):
    with pytest.raises(rr.ParameterError, match=rf"^{name} has {len(value)} entries.*a pair"):
        make(name, value)


@pytest.mark.parametrize("name", ["battery_mass", "shell_radius", "hip_offset", "gravity"])
def test_no_pair_where_there_is_one(name):
    with pytest.raises(rr.ParameterError, match=rf"^{name} is \(0\.1, 0\.1\).*number"):
        make(name, (0.1, 0.1))


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, "x", True, None, (0.1, 0.1)])
@pytest.mark.parametrize("name", PER_LEG)
def test_bad_entry_of_a_pair_is_named(name, bad):
    with pytest.raises(rr.ParameterError, match=rf"^{name}\[1\] is .*greater than zero"):
        make(name, (0.1, bad))


@pytest.mark.parametrize("pair", [(0.05, 0.08), [0.05, 0.08], np.array((0.05, 0.08))])
def test_a_pair_is_leg_1_and_leg_2(pair):
    p = rr.RRRobotParameters(leg_mass=pair, servo_mass=pair, leg_length=pair)
    assert p.leg_masses == p.servo_masses == p.leg_lengths == (0.05, 0.08)
    assert p.total_mass == pytest.approx(0.3 + 0.26, abs=1e-15)
    assert p.ground_clearance == pytest.approx(0.04, abs=1e-15)
    assert rr.RRRobotParameters(**json.loads(json.dumps(p.to_dict()))) == p


@given(st.sampled_from(POSITIVE), st.floats(1e-6, 1e6))
@examples(60)
def test_any_positive_number_is_kept(name, value):
    assert getattr(make(name, value), name) == value
    assert getattr(make(name, np.float64(value)), name) == value


@pytest.mark.parametrize("length", [0.12, 0.2, (0.1, 0.13)])
def test_a_leg_that_reaches_the_ground_warns_with_the_clearance(length):
    with pytest.warns(rr.GroundClearanceWarning) as caught:
        p = rr.RRRobotParameters(leg_length=length)
    clearance = 0.12 - max(p.leg_lengths)
    (warning,) = caught
    assert f"clearance of {clearance:.4g} m" in str(warning.message)
    assert warning.filename == __file__


def test_a_shorter_leg_does_not_warn():
    rr.RRRobotParameters(leg_length=0.1199)


def test_frozen_and_keyword_only():
    p = rr.RRRobotParameters()
    with pytest.raises(dataclasses.FrozenInstanceError):
        p.leg_mass = 1.0  # type: ignore[misc]
    with pytest.raises(TypeError):
        rr.RRRobotParameters(0.05)  # type: ignore[misc]
    assert p == rr.RRRobotParameters()
    assert hash(p) == hash(rr.RRRobotParameters())

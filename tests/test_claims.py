"""Each claim of the paper: the verdicts, and the numbers against what was found independently.

Speeds and yaw rates are those of a point-mass Kane formulation; other values are closed forms
worked out here, or measured once by the general KKT model.
"""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import rrrobot as rr
from rrrobot.paper import claims_axes, claims_travel
from rrrobot.paper.claims import CLAIMS
from rrrobot.paper.claims_travel import rolled, travel_per_cycle
from rrrobot.paper.item import AGREES, DIFFERS, OPEN
from rrrobot.paper.settled import (
    both_legs,
    cycle_points,
    distortion,
    fitted_circle,
    off_line,
    settled,
    swing,
)
from rrrobot.paper.workshop import Workshop
from rrrobot.paper.yaw_balance import attitude, yaw_balance
from tests.pages import are_printed

LATERAL, CIRCULAR, TURN = 0.009656, 0.0066765, 0.0208546
"""v [m/s] of the two gaits and yaw rate [rad/s] of the circular one, by Kane's method."""
R = 0.12
ITEMS = {item.key: item for item in CLAIMS}


@pytest.fixture(scope="module")
def shop():
    return Workshop(quick=True)


@pytest.fixture(scope="module")
def circular(shop):
    return settled(rr.FullModel(shop.robot), rr.gait("circular"))


class Found:
    """Rows of one claim, by the start of what they compare."""

    def __init__(self, shop, key):
        self.result = ITEMS[key].make(shop)

    def row(self, *words):
        (row,) = [r for r in self.result.rows if all(word in r.quantity for word in words)]
        return row

    def __getitem__(self, words):
        return self.row(*words if isinstance(words, tuple) else (words,)).ours

    def differing(self):
        return [row.quantity for row in self.result.rows if row.verdict == DIFFERS]


def test_each_claim_is_named_once_and_says_where_it_stands():
    assert len(ITEMS) == len(CLAIMS) == 21
    for item in CLAIMS:
        assert item.key.startswith("claim-") and item.title and "(sec. " in item.shows


def test_a_claim_can_fail(shop, monkeypatch):
    """Ten times the paper's yaw damping: hardly any drift; and none in the pitch's own damping."""
    monkeypatch.setattr(
        claims_travel, "FullModel", lambda robot: rr.FullModel(robot, damping=(0.01, 0.01, 0.1))
    )
    assert "circular gait, yaw rate" in Found(shop, "claim-curved-path").differing()
    monkeypatch.setattr(
        claims_axes, "FullModel", lambda robot: rr.FullModel(robot, damping=(0.01, 0.0, 0.01))
    )
    assert Found(shop, "claim-pitch-frequency").differing() == [
        "settled pitch frequency off the legs', part of it",
        "rest of the spectrum between harmonics, over the peak",
        "or, read as the body's own: its pitch frequency over the legs'",
    ]


def test_straight_line(shop):
    found = Found(shop, "claim-straight-line")
    assert found.differing() == []
    assert found["lateral gait, yaw rate"] < 1e-7
    assert found["off a line"] < 1e-5
    assert found["pitch ahead of yaw"] == pytest.approx(90.1, abs=0.2)
    assert found["apart"] < 1e-10 and found["most travel"] == 90.0
    assert found["off 2 pi r"] < 1e-9
    assert found["formula over"] == pytest.approx(0.00969 / LATERAL, rel=1e-3)


def test_straight_line_formula():
    """The net travel is the integral of r sin(yaw) d(pitch), for small angles -pi r p y sin d."""
    p, y = 0.25, 0.4
    for lead in (0.3, 1.2, 2.9):
        net = quad(lambda u, d=lead: R * math.sin(y * math.sin(u)) * p * math.cos(u + d),
                   0, 2 * math.pi)[0]  # fmt: skip
        assert travel_per_cycle(R, p, y, lead) == pytest.approx(net, rel=1e-10)
        assert rolled(R, p, y, lead)[-1] == pytest.approx((0.0, net), abs=1e-9)
        small = travel_per_cycle(R, 1e-3, 1e-3, lead)
        assert small == pytest.approx(-math.pi * R * 1e-6 * math.sin(lead), rel=1e-5)


def test_curved_path(shop):
    found = Found(shop, "claim-curved-path")
    assert found.differing() == []
    assert found["circular gait, yaw rate"] == pytest.approx(TURN, rel=1e-5)
    # The means of consecutive cycles lie on a regular polygon: v is along its sides.
    half = TURN * math.pi / 8
    assert found["circular gait, radius of the"] == pytest.approx(half / math.sin(half), rel=1e-6)
    assert found.result.rows[-1].ours == pytest.approx(CIRCULAR / TURN, rel=1e-4)


@pytest.mark.slow
def test_phase_difference(shop):
    found = Found(shop, "claim-phase-difference")
    assert found.differing() == [
        f"rolling alone, K at a lead of {lead} deg over K at 90 deg" for lead in (60, 30)
    ]
    assert found["K at a lead of 30"] == pytest.approx(2.0, rel=1e-3)
    assert found["lead of 60 deg"] == pytest.approx(2 / math.sqrt(3), rel=1e-3)
    assert found["largest K"] == pytest.approx(2.17, rel=0.01)
    assert found["spread of the yaw rate"] == pytest.approx(0.074, abs=0.005)
    assert found["spread of v / (pitch"] == pytest.approx(0.095, abs=0.005)
    assert found["single-axis"] == pytest.approx(38, abs=2)
    assert "from 64 to 119 deg" in found.row("spread of v / (pitch").note


def test_leg_axis(shop):
    found = Found(shop, "claim-leg-axis")
    assert found.differing() == []
    assert found["lateral and circular"] == pytest.approx(0.513, abs=0.01)
    assert found["share"] == pytest.approx(0.705, abs=0.01)
    assert found["opposite level"] == pytest.approx(5.4646, rel=1e-3)


@pytest.mark.slow
def test_start(shop):
    found = Found(shop, "claim-start")
    assert found.differing() == []
    assert found["four other starts: change of v"] < 1e-8
    assert found["elsewhere in the cycle: change of v"] == pytest.approx(1.4e-4, rel=0.1)
    # At rest at t = 0 the momentum of leg 1's speed 2.4 rad/s is kept: L / I, in the mean over I.
    angle = math.pi / 2 + 0.3 * np.sin(np.linspace(0, 2 * np.pi, 400, endpoint=False))
    other = np.roll(angle, -100)
    g11 = [
        rr.paper.yaw_mass_matrix(rr.RRRobotParameters(), pair)[0, 0]
        for pair in np.column_stack((angle, other))
    ]
    kept = -0.057 * 0.1 * R * 2.4 * np.mean(1 / np.array(g11))
    assert found["yaw model, lateral"] == pytest.approx(kept, rel=1e-6)
    assert found["pivoting model, lateral"] == pytest.approx(-18.8 / 30, rel=0.01)


def test_accessibility(shop):
    found = Found(shop, "claim-accessibility")
    assert found.differing() == []
    assert found["fewest"] == 23 and found["highest speed"] == pytest.approx(9.656, abs=2e-3)
    assert found["smallest radius of all"] == pytest.approx(11.3, abs=0.1)


def test_second_order(shop):
    found = Found(shop, "claim-second-order")
    assert found.differing() == []
    powers = [row.ours for row in found.result.rows]
    assert powers == pytest.approx([1, 1, 2, 2], abs=0.03)


@pytest.mark.slow
def test_legs_in_phase(shop):
    found = Found(shop, "claim-legs-in-phase")
    assert found.differing() == [
        f"legs opposite, offset {offset} deg, roll over yaw" for offset in (45, 0)
    ]
    assert found["legs in phase, roll"] < 1e-12 and found["offset 90 deg"] < 1e-12
    assert found["offset 45 deg"] == pytest.approx(1.10, abs=0.01)
    assert found["offset 0 deg"] == pytest.approx(2.137, abs=0.01)
    are_printed((found["offset 45 deg"], found["offset 0 deg"]),
                "errata.md", r"is ([\d.]+) times yaw, at 0° ([\d.]+) times")  # fmt: skip


@pytest.mark.slow
def test_pitch_linear(shop):
    found = Found(shop, "claim-pitch-linear")
    assert found.differing() == ["offset 0 deg, 0.3 rad: amplitude over the linear response"]
    higher = [row.ours for row in found.result.rows if "harmonics" in row.quantity]
    assert higher == pytest.approx([0.00296, 0.0396, 0.0873, 0.00956, 0.1772], rel=0.01)
    assert found["offset 0 deg, 0.6", "linear"] == pytest.approx(1.535, rel=0.01)
    # The general model, and the amplitude of the linear response in the docs of pitch_response.
    state = rr.simulate(rr.PitchModel(shop.robot), rr.gait("lateral"), 30.0).steady_state()
    lateral = found["offset 90 deg, 0.3", "linear"]
    assert lateral == pytest.approx(state.amplitude[1] / 0.2576, rel=1e-3)


def test_distortion_is_that_of_a_known_wave(shop, circular):
    t = circular.time
    wave = 0.1 + 0.2 * np.sin(8 * t) + 0.03 * np.cos(16 * t) + 0.04 * np.sin(24 * t)
    made = type("Made", (), {"euler": wave[:, None], "__len__": lambda self: len(t)})()
    assert distortion(made, 0) == pytest.approx(0.05 / 0.2, rel=1e-9)


def test_pitch_frequency(shop):
    found = Found(shop, "claim-pitch-frequency")
    assert [name[:13] for name in found.differing()] == ["settled pitch", "or, read as t"]
    assert found["settled pitch"] == 0.0 and found["rest of the spectrum"] < 1e-8
    assert found["its pitch frequency"] == pytest.approx(2 * math.pi / 1.08145 / 8, rel=1e-5)


def test_mean_pitch(shop):
    found = Found(shop, "claim-mean-pitch")
    assert found.differing() == []
    # S_c / (M_b r - S_s) of two legs at 45 degrees.
    s = 2 * 0.057 * 0.1 * math.sqrt(0.5)
    assert found["circular"] == pytest.approx(math.atan(s / (0.3 * R - s)), rel=1e-12)
    assert found["worst"] == pytest.approx(0.0186, abs=2e-4)


def test_pitch_model(shop):
    found = Found(shop, "claim-pitch-model")
    assert found.differing() == []
    assert found["rms of the plane"] == pytest.approx(0.0168, abs=3e-4)
    assert found["pivoting"] == pytest.approx(0.1521 / 0.0168, rel=0.02)


def test_roll(shop):
    found = Found(shop, "claim-roll")
    assert found.differing() == [
        "circular gait, roll over yaw",
        "gaits above 2 mm/s, median of roll over pitch",
        "gaits above 2 mm/s, median of roll over yaw",
    ]
    assert found["lateral gait, roll over pitch"] < 1e-5
    assert found["circular gait, roll over pitch"] == pytest.approx(0.3332, rel=1e-3)
    assert found["circular gait, roll over yaw"] == pytest.approx(1.1647, rel=1e-3)
    are_printed((found["circular gait, roll over pitch"], found["circular gait, roll over yaw"]),
                "errata.md", r"roll is ([\d.]+) of the pitch and ([\d.]+) of")  # fmt: skip


@pytest.mark.slow
def test_decoupled(shop):
    found = Found(shop, "claim-decoupled")
    assert found.differing() == [
        "yaw model, amplitude over the full model's",
        "yaw model, phase ahead of the full model's",
    ]
    assert found["pitch model, amplitude"] == pytest.approx(0.9987, abs=3e-4)
    assert found["yaw model, amplitude"] == pytest.approx(0.0891642 / 0.0816866, rel=1e-4)
    assert found["damping, amplitude"] == pytest.approx(1.0175, abs=1e-3)
    assert found["damping, phase"] == pytest.approx(0.92, abs=0.02)


def test_yaw_momentum(shop):
    found = Found(shop, "claim-yaw-momentum")
    assert found.differing() == []
    assert found["change of the momentum"] < 1e-8 and found["legs stop"] < 1e-7
    assert found["on the way"] > 0.3


def test_leg_cycles(shop):
    found = Found(shop, "claim-leg-cycles")
    assert found.differing() == []
    assert found["5 pi/8"] == pytest.approx(0.0129962291, abs=1e-9)
    assert found["from rest to rest"] < 1e-9
    assert abs(found["(90 + 23"]) < 1e-12 < abs(found["lopsided"])
    # -(integral of A_1 d phi_1) of one leg, by quadrature of eq (12).
    p = rr.RRRobotParameters()

    def slope(phi):
        g = rr.paper.yaw_mass_matrix(p, (phi, 1.5))[0]
        return -g[1] / g[0]

    assert found["one leg"] == pytest.approx(quad(slope, 1.2, 2.0)[0], rel=1e-8)


def test_reduction(shop):
    found = Found(shop, "claim-reduction")
    assert found.differing() == []
    assert found["yaw model, body's"] < 1e-8 < 1 < found["full model"]
    assert found["postures"] == 36 and found["off its goal"] < 1e-6


def test_yaw_amplitude(shop):
    found = Found(shop, "claim-yaw-amplitude")
    assert len(found.differing()) == 2
    # 2 A |sin(d/2)| a(o) for a small amplitude, docs/reduction.md.
    servo, leg = 2 * (0.053 + 0.057) * R**2, 2 * 0.057 * 0.1**2
    small = math.sqrt(2) * (servo + leg / 2) / servo
    assert found["yaw model, amplitude at"] == pytest.approx(small, rel=0.02)
    assert found["full model, the same"] == pytest.approx(1.065, abs=2e-3)
    assert found["yaw inertia"] == pytest.approx(1.165, abs=2e-3)
    assert found["full model's yaw amplitude"] == pytest.approx(0.0770228 / 0.0548017, rel=1e-3)
    are_printed((found["full model's yaw amplitude"],), "errata.md", r"are ([\d.]+) times larger")
    assert found["pitch and roll"] == pytest.approx(1.398, abs=2e-3)


def test_yaw_drift(shop):
    found = Found(shop, "claim-yaw-drift")
    assert len(found.differing()) == 1
    assert found["circular"] == pytest.approx(TURN / 0.01355, rel=1e-3)
    assert 0.6 < found["larger drift in the full model"] < 0.8


def test_yaw_drift_cause(shop, circular):
    found = Found(shop, "claim-yaw-drift-cause")
    assert len(found.differing()) == 2
    assert found["yaw model's drift"] == pytest.approx(0.0135522, rel=1e-5)
    assert found["as it swings"] == pytest.approx(-0.0119340, rel=1e-4)
    are_printed(
        (found["yaw model's drift"], found["as it swings"], TURN), "errata.md",
        r"round: ([\d.]+) rad/s becomes (\u2212[\d.]+)\. The full model's ([\d.]+) is",
    )  # fmt: skip
    assert found["with the roll too"] == pytest.approx(0.1370146, rel=1e-4)
    assert found["on the ground, over"] == pytest.approx(1.0, abs=1e-6)
    assert found["mean moment"] == pytest.approx(1.0, abs=1e-6)
    assert found["sideways"] == pytest.approx(1.041, abs=2e-3)
    assert found["twice", "yaw model's"] == pytest.approx(0.00985294 / 0.0135522, rel=1e-4)
    # Friction's share by hand: the legs' momentum forwards times the sideways rolling.
    given = attitude(circular)
    legs = rr.gait("circular")(given.time)
    speed = -0.057 * 0.1 * np.sin(legs.angle - given.pitch[:, None]) * legs.rate
    moment = -R * given.roll_rate * np.cos(given.pitch) * speed.sum(axis=1)
    assert moment.mean() / (0.01 * TURN) == pytest.approx(found["sideways"], rel=0.02)


@pytest.mark.slow
def test_pivoting_turns(shop):
    found = Found(shop, "claim-pivoting-turns")
    assert len(found.differing()) == 1
    assert found["over full model's"] == pytest.approx(0.1978 / TURN, rel=1e-3)
    assert found["zero momentum: drift over its"] == pytest.approx(1.0, abs=1e-6)
    assert found["its pitch alone"] == pytest.approx(-0.0073444 / 0.0135522, rel=1e-3)
    assert found["a tenth"] == pytest.approx(0.190 / 0.1978, rel=2e-3)


@pytest.mark.parametrize("offset", [30, 60])
def test_balance_gives_the_models_own_drift(shop, offset):
    """With everything switched on it is the full model's, or the pivoting one's, at any offset."""
    legs = both_legs(math.radians(offset))
    full = settled(rr.FullModel(shop.robot), legs)
    rate = yaw_balance(shop.robot, legs, attitude(full), rolls=True).settled_rate(0.01)
    assert rate.mean() == pytest.approx(full.steady_state().yaw_rate, rel=1e-5)
    pivoting = settled(rr.PivotingModel(shop.robot), legs)
    free = yaw_balance(shop.robot, legs, attitude(pivoting), rolls=False).free_rate()
    assert free.mean() == pytest.approx(pivoting.steady_state().yaw_rate, rel=1e-5)
    level = yaw_balance(shop.robot, legs, attitude(full).level(), rolls=False).free_rate()
    assert level.mean() == pytest.approx(rr.studies.yaw_drift(shop.robot, legs), rel=1e-9)


def test_tools(circular):
    around = 0.3 * np.column_stack((np.cos(np.arange(5) / 9), np.sin(np.arange(5) / 9))) + (2, 1)
    circle = fitted_circle(around)
    assert circle.radius == pytest.approx(0.3, rel=1e-9) and circle.misfit < 1e-12
    line = np.column_stack((np.arange(5.0), 2 * np.arange(5.0)))
    assert off_line(line) < 1e-12
    line[2] += (-0.02, 0.01)
    assert 0.005 < off_line(line) < 0.0224
    assert swing(circular) == pytest.approx(circular.steady_state().amplitude, rel=0.02)
    assert len(cycle_points(circular)) == 19
    with pytest.raises(rr.GaitError, match="period"):
        settled(rr.FullModel(circular.robot), rr.StillLegs((1.0, 1.0)))


def test_verdicts_are_open_where_the_paper_prints_nothing(shop):
    rows = Found(shop, "claim-accessibility").result.rows
    assert {row.verdict for row in rows if row.paper is None} == {OPEN}
    assert {row.verdict for row in rows if row.paper is not None} == {AGREES}

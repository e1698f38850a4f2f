"""Limit cycles of many gaits at once: each its own, the steady state of long runs, neighbours."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.batch import RESULT, lower, settled
from rrrobot.momentum.cycle_search import _search
from rrrobot.orbits.many import Orbits, orbits_of
from tests.some import some

ROBOT = rr.Robot.from_parameters()
STATUS = RESULT.index("status")


def some_gaits(n: int, harmonics: int = 1, largest: float = 0.4, seed: int = 0) -> GaitBatch:
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.05, largest, (n, harmonics, 2)) / np.arange(1, harmonics + 1)[:, None] ** 2
    phase = rng.uniform(0, 2 * np.pi, size.shape)
    return GaitBatch(
        rng.uniform(0, np.pi, (n, 2)), np.zeros((n, 2)), size * np.sin(phase), size * np.cos(phase),
        rng.uniform(4, 11, n),
    )  # fmt: skip


def test_a_gait_has_the_same_bits_in_any_chunk():
    """Also those that need the second try, or have no cycle that holds."""
    setting, gaits = lower(rr.FullModel(ROBOT)), some_gaits(37, 2, 2.5, seed=3)
    whole = orbits_of(setting, gaits, 20)
    assert len(set(whole.results[:, STATUS])) > 1
    for first, last in ((0, 1), (5, 6), (16, 37), (3, 21)):
        part = orbits_of(setting, gaits.rows(slice(first, last)), 20)
        np.testing.assert_array_equal(part.results, whole.results[first:last])
        np.testing.assert_array_equal(part.multiplier, whole.multiplier[first:last])


def test_the_search_is_compiled_once_however_it_begins():
    """Compiling takes long; arguments of other types would have it done again."""
    setting = lower(rr.FullModel(ROBOT))
    found = orbits_of(setting, some_gaits(3), 20)
    ways = len(_search.signatures)
    # Wild gaits are tried again; others begin at a neighbour's orbit.
    assert (orbits_of(setting, some_gaits(37, 2, 2.5, seed=3), 20).results[:, STATUS] != 0).any()
    first = Orbits(*(part[:1] for part in found))
    orbits_of(setting, some_gaits(3), 20, stability="none", near=first)
    assert len(_search.signatures) == ways


@pytest.mark.parametrize(
    "model", [rr.FullModel, rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel],
    ids=lambda m: m.name,
)  # fmt: skip
def test_long_runs_come_to_them(model):
    """300 cycles in the same steps; those errors add up in the run's heading and momentum."""
    setting, gaits = lower(model(ROBOT)), some_gaits(16)
    found = orbits_of(setting, gaits, 32)
    assert (found.results[:, STATUS] == 0).all() and found.periods.max() < 25
    long = settled(setting, gaits, cycles=np.full(16, 300), counted=2, steps=32)
    compared = [i for i, name in enumerate(RESULT) if "phase" not in name and i < 12]
    np.testing.assert_allclose(
        found.results[:, compared], long.results[:, compared], rtol=1e-9, atol=1e-10
    )
    np.testing.assert_allclose(found.results[:, 14], long.results[:, 14], rtol=1e-9)
    heights = RESULT.index("clearance")
    np.testing.assert_allclose(found.results[:, heights], long.results[:, heights], rtol=1e-8)


def test_multipliers_are_those_of_the_single_search():
    setting, gaits = lower(rr.FullModel(ROBOT)), some_gaits(3, seed=5)
    found = orbits_of(setting, gaits, 40)
    for i in range(3):
        gait = rr.FourierGait(offset=gaits.offset[i], sine=gaits.sine[i], cosine=gaits.cosine[i],
                              angular_frequency=float(gaits.angular_frequency[i]))  # fmt: skip
        cycle = rr.limit_cycle(rr.FullModel(ROBOT), gait)
        assert found.multiplier[i] == pytest.approx(abs(cycle.multipliers[0]), abs=1e-6)
        assert found.results[i, 0] == pytest.approx(cycle.speed, rel=1e-8)
        np.testing.assert_allclose(found.point[i], cycle.point, atol=1e-8)


def test_a_neighbours_orbit_leads_there_in_three_periods():
    setting, gaits = lower(rr.FullModel(ROBOT)), some_gaits(1, seed=9)
    base = orbits_of(setting, gaits, 20)
    others = GaitBatch(*(np.repeat(part, 4, axis=0) for part in gaits))
    others.offset[:] += 1e-4 * np.arange(1, 9).reshape(4, 2)
    near = orbits_of(setting, others, 20, stability="none", near=base)
    alone = orbits_of(setting, others, 20)
    assert near.periods.max() <= 4 < alone.periods.min()
    np.testing.assert_allclose(near.results[:, :13], alone.results[:, :13], rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize(
    ("damping", "largest", "n"),
    some(
        [(0.01, 0.8, 100), (0.01, 1.2, 1500), (0.01, 2.5, 1500), (0.002, 0.8, 800),
         (0.005, 0.8, 800), (0.02, 3.0, 800)],
        ["(0.01, 0.8, 100)"],
    ),
)  # fmt: skip
def test_what_is_known_of_stability_agrees_with_the_multipliers(damping, largest, n):
    setting = lower(rr.FullModel(ROBOT, damping=damping))
    gaits = some_gaits(n, 1, largest, seed=1)
    exact, known = (orbits_of(setting, gaits, 16, stability=s) for s in ("exact", "known"))
    np.testing.assert_array_equal(known.results[:, STATUS], exact.results[:, STATUS])
    np.testing.assert_allclose(known.multiplier, exact.multiplier, atol=0.07)
    assert known.periods.mean() < exact.periods.mean()

"""Gaits that get a robot free: what the search is made of, against other ways to compute it."""

import re
from copy import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.drive.gaits import GaitBatch
from rrrobot.escape import confirming, story
from rrrobot.escape.atlas import Atlas
from rrrobot.escape.bench import Bench, Outcome
from rrrobot.escape.bodies import capsules_of
from rrrobot.escape.capsules import Capsules, clearances
from rrrobot.escape.finding import find_gaits
from rrrobot.escape.goals import goal_of
from rrrobot.escape.limits import EscapeLimits, Rules
from rrrobot.escape.loss import rocking_damping, rocking_modes
from rrrobot.escape.polish import Scale, climb, judge
from rrrobot.escape.report import report_html
from rrrobot.escape.small import best_small, cost, leaning, small_gaits
from rrrobot.escape.spaces import spaces, symmetric
from rrrobot.escape.unstuck import Unstuck
from rrrobot.escape.way_rows import off_rows
from rrrobot.momentum.tree import tree_of
from rrrobot.robot.limits import JointEnds
from tests.some import some
from tests.terrain import Egg
from tests.test_belly import board
from tests.test_rolling_off import LIMITS, crane_of, off

UP = np.array((0.0, 2.7, 0.3) * 2)
"""Legs of `biped` upward."""


@pytest.fixture(scope="module")
def biped():
    """Two legs of three joints on a box that rolls on a sphere."""
    text = rr.robot.legged_urdf(2, body_size=(0.3, 0.2, 0.1), leg_mass=0.5)
    return rr.Robot.from_urdf(text, shell=rr.Sphere(0.3), shell_center=(0, 0, 0.25))


@pytest.fixture(scope="module")
def bench(biped):
    bare = rr.FullModel(biped, damping=None)
    model = rr.FullModel(biped, damping=rocking_damping(bare, UP, 0.15))
    shapes = rr.belly.Shapes.of(biped)
    found = rocking_modes(model, UP)
    capsules, limbs = capsules_of(shapes, ())
    made = Bench(model, capsules, limbs, min(m.decay_rate for m in found))
    return made.near(shapes, UP[None], 0.005)


# Capsules


@pytest.mark.parametrize("curvature", some((0.0, 2.5, -0.4), {"2.5"}))
def test_capsules_stand_where_pinocchio_and_coal_put_them(curvature):
    import coal

    text = rr.robot.legged_urdf(3)
    robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.3), shell_center=(0.01, 0, 0.25))
    rng = np.random.default_rng(3)
    n, m = 4, 8
    body = rng.integers(0, robot.model.njoints - 1, m)
    ends, radius = rng.normal(0, 0.1, (m, 2, 3)), rng.uniform(0.01, 0.03, m)
    pairs = np.array([(i, j) for i in range(m) for j in range(i) if body[i] != body[j]])
    capsules = Capsules(body, ends, radius, np.arange(m), pairs, np.zeros(len(pairs)))
    tree = tree_of(robot)
    angle = rng.uniform(-2, 2, (n, 1, robot.n_legs))
    normal = rng.normal(0, 0.2, (n, 1, 3)) + np.array((0, 0, 1))
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    s = rng.normal(0, 0.02, (n, 1, 3)) + np.array((0, 0, 0.8))
    height, least = clearances(tree, capsules, m, angle, normal, s, curvature)
    single = [capsules._replace(pairs=pair[None], extra=np.zeros(1)) for pair in pairs]
    apart = np.array([clearances(tree, one, m, angle, normal, s, curvature)[1] for one in single])
    np.testing.assert_array_equal(least, apart.min(axis=0))
    model, data = robot.model, robot.model.createData()
    for g in range(n):
        q = pin.neutral(model)
        q[7:] = angle[g, 0]
        pin.forwardKinematics(model, data, q)
        shapes = []
        for c in range(m):
            place = data.oMi[int(body[c]) + 1]
            a, b = (place.act(end) for end in ends[c])
            turn = pin.Quaternion.FromTwoVectors(np.array((0.0, 0, 1)), b - a).toRotationMatrix()
            shape = coal.Capsule(radius[c], np.linalg.norm(b - a))
            shapes.append((shape, coal.Transform3s(turn, (a + b) / 2)))
            # The contact is s below the origin, which is the shell's centre.
            contact = robot.shell_placement.translation - s[g, 0]
            if curvature == 0:
                low = min(normal[g, 0] @ (a - contact), normal[g, 0] @ (b - contact))
            else:
                middle = contact - normal[g, 0] / curvature
                t = np.linspace(0, 1, 20001)[:, None]
                far = np.linalg.norm(a + t * (b - a) - middle, axis=1)
                low = far.min() - 1 / curvature if curvature > 0 else -1 / curvature - far.max()
            assert height[g, c] == pytest.approx(low - radius[c], abs=1e-8)
        for (i, j), told in zip(pairs, apart[:, g], strict=True):
            result = coal.DistanceResult()
            coal.distance(*shapes[i], *shapes[j], coal.DistanceRequest(), result)
            if result.min_distance > 1e-6:
                assert told == pytest.approx(result.min_distance, abs=1e-5)
            else:
                assert told < 1e-5
    assert (apart > 0).sum() > 20


def test_configurations_of_a_cycle_stand_on_the_ground_as_its_capsules_do(bench):
    rng = np.random.default_rng(4)
    swing = 0.05 * rng.normal(size=(2, 3, 1, 6))
    gaits = GaitBatch(np.tile(UP, (3, 1)), np.zeros((3, 6)), *swing, np.full(3, 9.0))
    every, out = bench.configurations(gaits), bench(gaits)
    model, robot = bench.model.model, bench.model.robot
    data, shapes = model.createData(), rr.belly.Shapes.of(robot)
    for i, cycle in enumerate(every):
        assert np.ptp(cycle, axis=0)[7:].min() > 0.01
        for q in cycle:
            pin.forwardKinematics(model, data, q)
            center = data.oMi[1].act(robot.shell_placement.translation)
            assert center[2] == pytest.approx(0.3, abs=1e-9)
        found = rr.belly.clearances(shapes, cycle, rr.Plane())
        # Capsules enclose what Coal knows.
        limbs = [k for k, link in enumerate(found.links) if link != "body"]
        assert found.ground[:, limbs].min() > out.height[i, :-1].min() - 1e-9
        assert found.ground[:, limbs].min() < out.height[i, :-1].min() + 0.1
        tilt = [np.arccos(pin.Quaternion(q[3:7].copy()).matrix()[2, 2]) for q in cycle]
        assert max(tilt) == pytest.approx(out.most_tilt[i], rel=1e-6)


def test_capsules_that_overlap_tell_what_coal_tells_in_the_posture():
    text = rr.robot.legged_urdf(2, body_size=(0.3, 0.2, 0.1), leg_mass=0.5)
    robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.3), shell_center=(0, 0, 0.25))
    shapes = rr.belly.Shapes.of(robot)
    bench = Bench(rr.FullModel(robot, damping=0.1), *capsules_of(shapes, ()), 1.0)
    folded = np.array((0.0, 2.44, 1.77) * 2)
    q = pin.neutral(robot.model)
    q[7:] = folded
    exact = rr.belly.clearances(shapes, q[None], rr.Plane()).between[0]
    near = bench.still(folded[None])[1][0]
    least = 0.5 * (near + exact)
    assert near < exact - 0.02
    assert bench.exact(shapes, folded[None]).min() == pytest.approx(exact, abs=1e-9)
    bench = bench.near(shapes, folded[None], least)
    # Of the links that are nearest it tells how much nearer they may come, all but a millimetre.
    k = int(bench.exact(shapes, folded[None])[0].argmin())
    whole = bench.capsules
    bench.capsules = whole._replace(pairs=whole.pairs[k, None], extra=whole.extra[k, None])
    assert bench.still(folded[None])[1][0] - least == pytest.approx(exact - 1e-3, abs=1e-9)
    bench.capsules = whole
    nearer = folded + np.array((0.0, 0.0, 0.2) * 2)
    assert bench.still(nearer[None])[1][0] < bench.still(folded[None])[1][0]


# Small gaits


def test_forms_of_small_gaits_predict_travel_and_rocking(bench):
    omega = 9.0
    (small,) = small_gaits(bench, UP, np.array([omega]))
    rng = np.random.default_rng(0)
    a = 0.02 * (rng.normal(size=(6, 6)) + 1j * rng.normal(size=(6, 6)))
    gaits = GaitBatch(
        np.tile(UP, (6, 1)), np.zeros((6, 6)), a.real[:, None].copy(), a.imag[:, None].copy(),
        np.full(6, omega),
    )  # fmt: skip
    found = bench(gaits, forces=False, clearance=False)
    told = np.real(np.einsum("nj,kjl,nl->nk", a.conj(), small.travel, a))
    for k in range(3):
        largest = np.abs(found.travel[:, k]).max()
        np.testing.assert_allclose(told[:, k], found.travel[:, k], atol=0.01 * largest)
    np.testing.assert_allclose(a @ small.rocking.T, found.rocking, atol=2e-3 * 0.1)
    for form in small.travel:
        np.testing.assert_allclose(form, form.conj().T, atol=1e-12)


def test_no_small_gait_of_the_same_cost_is_better_than_the_eigenvector(bench):
    (small,) = small_gaits(bench, UP, np.array([9.0]))
    metric = cost(small, np.full(6, 0.5), 0.2)
    form = small.travel[0]
    (value, best), *_ = best_small(form, metric, np.eye(6), 1)
    assert np.real(best.conj() @ metric @ best) == pytest.approx(1)
    assert np.real(best.conj() @ form @ best) == pytest.approx(value)
    rng = np.random.default_rng(1)
    for _ in range(300):
        a = rng.normal(size=6) + 1j * rng.normal(size=6)
        size = np.real(a.conj() @ metric @ a)
        assert np.real(a.conj() @ form @ a) / size <= value * (1 + 1e-9)


def test_damping_gives_both_modes_their_ratio(biped):
    bare = rr.FullModel(biped, damping=None)
    model = rr.FullModel(biped, damping=rocking_damping(bare, UP, 0.08))
    found = rocking_modes(model, UP)
    ratios = [m.decay_rate / abs(m.eigenvalue) for m in found]
    np.testing.assert_allclose(ratios, 0.08, rtol=0.05)


# Symmetry


def test_spaces_are_what_reflections_keep():
    text = rr.robot.legged_urdf(4)
    robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.3), shell_center=(0, 0, 0.25))
    found = spaces(robot)
    sizes = {}
    for name, basis, _ in found:
        sizes.setdefault(name, []).append(basis.shape[1])
        np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-12)
    # Twelve joints; each reflection halves the space.
    assert sizes == {
        "all": [12], "alike": [3], "mirrored": [3, 3, 6], "opposite": [3, 3, 6],
        "front-back": [6, 6], "diagonal": [6, 6], "one leg": [3] * 4,
    }  # fmt: skip
    (alike,) = (basis for name, basis, _ in found if name == "alike")
    names = [robot.legs[k] for k in np.flatnonzero(np.abs(alike[:, 0]) > 1e-9)]
    assert {name.split("_")[1] for name in names} <= {"haa", "hfe", "kfe"}
    two = np.random.default_rng(0).normal(size=(2, 12))
    postures = symmetric(robot, two)
    np.testing.assert_allclose(symmetric(robot, postures), postures, atol=1e-12)
    np.testing.assert_array_equal(postures[0], symmetric(robot, two[0]))


def test_gaits_of_a_symmetric_space_do_not_travel_where_they_must_not(bench):
    rng = np.random.default_rng(5)
    for name, basis, _ in spaces(bench.model.robot, ("mirrored", "opposite")):
        m = basis.shape[1]
        a = 0.1 * basis @ (rng.normal(size=m) + 1j * rng.normal(size=m))
        offset = symmetric(bench.model.robot, UP + 0.1 * rng.normal(size=6))
        gait = GaitBatch(
            offset[None], 0 * offset[None], a.real[None, None], a.imag[None, None], np.array([9.0])
        )
        ((x, y, turn),) = bench(gait, forces=False, clearance=False).travel
        assert abs(y) < 1e-3 * max(abs(x), 1e-6), name
        assert abs(turn) < 1e-3 * max(abs(x), 1e-6), name


# Goals and limits


def test_goals_say_where_they_lead():
    travel = np.array([[0.3, 0.4, 0.01]])
    ahead = np.rad2deg(np.arctan2(0.4, 0.3))
    assert goal_of(f"direction:{ahead}").value(travel)[0] == pytest.approx(0.5)
    assert goal_of(f"direction:{ahead}").slack(travel, 0.5).min() > 0.89
    assert goal_of("forward").slack(travel, 0.5).min() < 0
    assert goal_of("turn-right").value(travel)[0] == pytest.approx(-0.01)
    assert goal_of("off:90").leans
    for bad in ("up", "direction", "direction:x", "direction:inf", "off:"):
        with pytest.raises(rr.ParameterError, match="must be one of forward, backward"):
            goal_of(bad)


def test_extent_of_gaits_with_harmonics():
    rng = np.random.default_rng(2)
    gaits = GaitBatch(
        rng.normal(size=(3, 2)), np.zeros((3, 2)), rng.normal(size=(3, 2, 2)),
        rng.normal(size=(3, 2, 2)), np.array((2.0, 5.0, 9.0)),
    )  # fmt: skip
    low, high, rate = gaits.reach()
    for i in range(3):
        motion = gaits.gait(i)(np.linspace(0, 2 * np.pi / gaits.angular_frequency[i], 4001))
        np.testing.assert_allclose(low[i], motion.angle.min(axis=0), atol=0.02)
        np.testing.assert_allclose(high[i], motion.angle.max(axis=0), atol=0.02)
        np.testing.assert_allclose(rate[i], np.abs(motion.rate).max(axis=0), rtol=0.02)


def test_effort_limits_that_limit_nothing_are_none():
    strong = rr.robot.legged_urdf(2, max_torque=1000.0)
    robot = rr.Robot.from_urdf(strong, shell=rr.Sphere(0.3))
    assert robot.joints.unlimited == robot.legs and np.isinf(robot.joints.effort).all()
    robot = rr.Robot.from_urdf(rr.robot.legged_urdf(2, max_torque=3.0), shell=rr.Sphere(0.3))
    assert robot.joints.unlimited == () and (robot.joints.effort == 3.0).all()
    assert rr.Robot.from_parameters().joints.unlimited == ()  # 1e9: nobody would take it for one


# Polish


class Landscape:
    """Stands for a bench: travel and friction are closed forms of the first two offsets."""

    def __call__(self, gaits):
        n = len(gaits.offset)
        x, y = gaits.offset[:, 0], gaits.offset[:, 1]
        ones = np.ones(n)
        return Outcome(
            np.column_stack((1.0 + x + 0.5 * y, 0 * x, 0 * x)), 0 * ones, np.zeros((n, 2)),
            np.zeros((n, 4, 2)), 0 * ones, ones, x**2 + y**2, np.zeros((n, 2)), ones,
            np.ones((n, 2)), ones,
        )  # fmt: skip


def test_polish_finds_the_constrained_optimum():
    ends = JointEnds(np.full(2, -9.0), np.full(2, 9.0), np.full(2, 99.0), np.full(2, np.inf))
    rules = Rules(goal_of("forward"), EscapeLimits(friction=0.25 / 0.96), ends, 0.3, 0.4)
    bench = Landscape()
    start = GaitBatch(
        np.array([[0.1, -0.2]]), np.zeros((1, 2)), *[np.zeros((1, 1, 2))] * 2, np.array([5.0])
    )
    begun = judge(rules, start, bench(start))[0]
    *_, best = climb(bench, rules, begun, Scale(np.full(2, 0.5), 1), iterations=60)
    # Within the circle of radius 1/2, x + y/2 is greatest along (2, 1).
    assert best.valid and best.binding == ("friction",)
    assert best.value == pytest.approx(1 + 0.5 * np.sqrt(1.25), rel=5e-3)
    np.testing.assert_allclose(best.gait.offset[0], np.array((2, 1)) / np.sqrt(5) / 2, atol=0.03)


# From the atlas to a gait


def test_grown_gaits_keep_within_every_limit(bench):
    ends = EscapeLimits().ends(bench.model.robot)
    rules = Rules(goal_of("forward"), EscapeLimits(), ends, 0.25, 0.3)
    atlas = Atlas(bench.model, UP[None], [bench], ends, 0.25, ("all", "opposite"), (0.9, 1.1))
    seeds = atlas.seeds(rules, 4)
    assert seeds == sorted(seeds, key=lambda seed: -seed.predicted)
    best = max(atlas.grown(rules, seeds), key=lambda one: (one.valid, one.value))
    assert best.valid and best.value > 0.005
    # What the engine says of it, the general model says too, joint by joint.
    gait = best.gait.gait(0)
    period = gait.period
    settled = np.ceil(bench.settle_time / period) * period
    t = rr.simulate(bench.model, gait, settled + 4 * period, period / 96)
    state, last = t.steady_state(after=settled - 1e-9), slice(-97, None)
    np.testing.assert_allclose(state.velocity[0], best.value, rtol=2e-3)
    torque = np.abs(t.leg_torque[last]).max(axis=0)
    np.testing.assert_allclose(best.outcome.torque[0], torque, rtol=5e-3, atol=1e-3)
    assert best.outcome.friction[0] == pytest.approx(t.required_friction[last].max(), rel=5e-3)
    # The search sees the tilt at the engine's steps only.
    tilt = np.arccos(np.cos(t.euler[last, 0]) * np.cos(t.euler[last, 1])).max()
    assert 0.97 * tilt < best.outcome.most_tilt[0] <= tilt * (1 + 1e-4)


def test_a_larger_budget_sees_all_that_a_smaller_one_saw(bench):
    ends = EscapeLimits().ends(bench.model.robot)
    rules = Rules(goal_of("forward"), EscapeLimits(), ends, 0.25, 0.3)
    atlas = Atlas(bench.model, UP[None], [bench], ends, 0.25, ("all", "mirrored"), (0.9, 1.1))
    seen, values = [], []
    for budget in (150, 300, 600):
        begun = bench.simulated
        found = find_gaits(bench, atlas, rules, budget=budget, harmonics=2)
        assert bench.simulated - begun < budget + 400
        seen.append({one.gait.sine.tobytes() for one in found})
        values.append(found[0].value)
        assert found[0].valid
    assert seen[0] <= seen[1] <= seen[2] and len(seen[0]) < len(seen[2])
    assert values == sorted(values) and values[2] > values[0]


def test_gaits_whose_links_touch_are_taken_up_from_where_they_are(bench):
    """What `nearer` says of a gait is heard: the next bench is used, and the gait is not told."""
    ends = EscapeLimits().ends(bench.model.robot)
    rules = Rules(goal_of("forward"), EscapeLimits(), ends, 0.25, 0.3)
    atlas = Atlas(bench.model, UP[None], [bench], ends, 0.25, ("all",), (0.9, 1.1))
    strict, refused = copy(bench), []
    strict.capsules = bench.capsules._replace(extra=bench.capsules.extra - 0.01)

    def nearer(at, one):
        if at is bench and one.value > 0.005:
            refused.append(one)
            return strict
        return None

    found = find_gaits(bench, atlas, rules, budget=400, harmonics=1, nearer=nearer)
    assert refused and not any(one is other for one in found for other in refused)
    assert found[0].valid and found[0].value > 0.005
    assert found[0].outcome.apart[0] == strict(found[0].gait).apart[0]


def test_gaits_that_settle_no_more_where_links_are_apart_end_the_search(bench):
    class Unsettled(type(bench)):
        def __call__(self, *args, **options):
            out = super().__call__(*args, **options)
            return out._replace(variation=np.full_like(out.variation, np.inf))

    ends = EscapeLimits().ends(bench.model.robot)
    rules = Rules(goal_of("forward"), EscapeLimits(), ends, 0.25, 0.3)
    atlas = Atlas(bench.model, UP[None], [bench], ends, 0.25, ("all",), (1.0,))
    wild = copy(bench)
    wild.__class__ = Unsettled
    found = find_gaits(
        bench, atlas, rules, budget=400, harmonics=1,
        nearer=lambda at, one: wild if at is bench else None,
    )  # fmt: skip
    assert len(found) == 1 and np.isfinite(found[0].value)


def test_what_is_returned_the_kkt_system_confirms(monkeypatch):
    """The momentum form tells what is worth its time, with the same numbers; what the KKT system
    then rejects is not returned."""
    told = []

    def confirm(*args, method="kkt", **options):
        found = confirming.confirm(*args, method=method, **options)
        by_kkt = [one for how, one in told if how == "kkt"]
        if method == "kkt" and not by_kkt:
            found = replace(found, met=False)
        told.append((method, found))
        return found

    monkeypatch.setattr(story, "confirm", confirm)
    robot = rr.Robot.from_parameters()
    found = rr.unstick(robot, goals=["left"], budget=300, postures=1).found["left"]
    assert [how for how, _ in told] == ["momentum", "kkt"] * 2
    (_, quick), (_, rejected), _, (_, last) = told
    assert found == (last,) and last.met
    for one, method in ((quick, "momentum"), (rejected, "kkt")):
        assert one.trajectory.metadata["integration"]["method"] == method
    assert quick.value == pytest.approx(rejected.value, rel=1e-6) and quick.ramp == rejected.ramp
    np.testing.assert_allclose(quick.torque, rejected.torque, rtol=1e-6)
    for name, value in quick.measured.items():
        assert rejected.measured[name] == pytest.approx(value, rel=1e-6), name


def test_a_robot_that_tips_is_told(biped):
    high = rr.Robot.from_urdf(biped.urdf, shell=rr.Sphere(0.07), shell_center=(0, 0, 0.02))
    with pytest.raises(rr.ModelError, match="it tips over, or does not rest"):
        rocking_damping(rr.FullModel(high, damping=None), UP, 0.1)
    with pytest.raises(rr.ModelError, match="needs one of at most"):
        rocking_damping(rr.FullModel(biped, damping=None), UP, 0.7)


def test_the_damping_of_a_small_robot_goes_with_its_size():
    """With all lengths a tenth, moments of inertia times frequency are 10^-1.5 of before."""
    sizes = {"leg_length": 0.1, "hip_offset": 0.12, "shell_radius": 0.12}
    whole, tenth = (
        rr.FullModel(
            rr.Robot.from_parameters(
                rr.RRRobotParameters(**{name: k * size for name, size in sizes.items()})
            ),
            damping=None,
        )
        for k in (1.0, 0.1)
    )
    up = np.full(2, np.pi / 2)
    large, small = (rocking_damping(model, up, 0.05) for model in (whole, tenth))
    assert small.x / large.x == pytest.approx(10**-1.5, rel=0.02)
    assert small.y / large.y == pytest.approx(10**-1.5, rel=0.02)
    lossy = rr.FullModel(tenth.robot, damping=small)
    ratios = [mode.decay_rate / abs(mode.eigenvalue) for mode in rocking_modes(lossy, up)]
    assert ratios == pytest.approx([0.05, 0.05], rel=0.1)


def test_gaits_on_a_slope_begin_at_rest_there():
    """Upright is far from it: rolling back turns a robot, and a heading on a slope stays."""
    angle = np.deg2rad(5.0)
    slope = rr.Plane((-np.sin(angle), 0.0, np.cos(angle)))
    for ground, leans in ((slope, True), (rr.Plane(), False)):
        belly = rr.fit_belly(rr.robot.legged_urdf(4), ground=ground)
        bench = story._Work(belly, EscapeLimits(), None, ("all",), None, 0.1, 1).bench
        if leans:
            assert bench.rest == pytest.approx(belly.rest[:2]) and bench.rest[1] < -angle
        else:
            assert bench.rest is None


@pytest.mark.slow
@pytest.mark.parametrize("side", [0, 1])
def test_solo12_gets_free_along_and_across_a_slope(side):
    angle = np.deg2rad(5.0)
    normal = np.array((0.0, 0.0, np.cos(angle)))
    normal[side] = -np.sin(angle)
    found = rr.unstick("solo12", ground=rr.Plane(normal), goals=["forward"], budget=600, postures=2)
    best = found.best("forward")
    assert best.met and best.value > 5e-3 and best.discrepancy < 1e-2


def test_legs_that_move_nothing_lean_nowhere():
    """Wheels: no amplitude of theirs rocks the robot, and none is made of 0/0."""
    still = SimpleNamespace(rocking=np.zeros((2, 4), dtype=complex))
    assert np.all(leaning(still, np.eye(4, dtype=complex), 0.0, 1.0) == 0)
    swings = SimpleNamespace(rocking=np.ones((2, 4), dtype=complex))
    assert leaning(swings, np.eye(4, dtype=complex), 1.0, 0.0) == pytest.approx(0.5)


def test_a_way_off_a_rock_is_told_whole():
    belly = crane_of(0.15)
    way = off(belly, "off:90")
    rows, share = off_rows(way), np.abs(way.trajectory.leg_torque).max() / 5.0
    assert rows["largest torque over its limit"] == f"{100 * share:.0f} %" != "0 %"
    said = rows["set-points of the joints"]
    assert said.startswith(f"off_90.csv and .ros.json end at {way.drive.duration:.2f} s")
    goals = [way.goal, goal_of("forward")]
    found = replace(Unstuck.begun(belly, LIMITS, goals, None), off={"off:90": way})
    page = report_html(replace(found, reasons={"forward": "none"}), films=False)
    cells = re.findall("<td[^>]*>(.*?)</td>", page)
    assert "" not in cells and cells.count("none feasible") == 1


@pytest.mark.slow
def test_a_robot_on_an_egg_of_one_s_own_gets_free():
    """A support function with an odd part: searched by the engine, confirmed by the KKT system."""
    robot = rr.Robot.from_urdf(
        rr.urdf_path("rrrobot"), shell=Egg(0.12, 0.03), legs=("leg_1", "leg_2")
    )
    found = rr.unstick(rr.fit_belly(robot, form="own"), goals=["forward"], budget=400, postures=1)
    best = found.best("forward")
    assert best.met and best.value > 5e-3 and best.discrepancy < 1e-3
    assert best.trajectory.robot.shell is robot.shell


def test_groups_that_do_not_exist_are_refused(biped):
    with pytest.raises(rr.ParameterError, match="group is 'twins': it must be one of all, alike"):
        spaces(biped, ("twins",))
    with pytest.raises(rr.ParameterError, match="friction is 0"):
        EscapeLimits(friction=0.0)


def test_legs_that_cannot_clear_the_ground_are_told_with_what_to_try():
    """Their limits keep them below the belly: the limb, by how much, and ways out are named."""
    low = board().replace('lower="-1.0" upper="1.0"', 'lower="0.5" upper="1.0"')
    robot = rr.Robot.from_urdf(low, shell=rr.Sphere(1.0))
    found = rr.unstick(robot, goals=["forward"], budget=200)
    assert not found.met and not found.found
    told = found.reasons["forward"]
    assert "mm in the ground within" in told and "touches the ground" in told
    assert "within the joint limits" in told and "Try" in told and "on a rock legs may hang" in told


def test_a_belly_that_tips_over_is_told_with_what_to_try():
    robot = rr.Robot.from_urdf(board(arms=False), shell=rr.Sphere(1.0))
    found = rr.unstick(rr.fit_belly(robot, ground=rr.Boulder(0.04)), budget=200)
    told = set(found.reasons.values())
    assert not found.met and len(told) == 1
    (text,) = told
    assert "mm above the centre of curvature" in text and "larger boulder" in text and "Try" in text

"""Cycles of machines with most net motion: exact gradients, and nothing else that is better."""

import numpy as np
import pytest
from matplotlib.contour import QuadContourSet

import rrrobot as rr
from rrrobot.machines.cycles import ShapePlane, _Gain
from rrrobot.reduction.paths import largest_region
from tests.some import some

reduction = rr.machines.Reduction
BEST = {
    "snake, x": ("kinematic_snake", "x", (0.4, 1.6)),
    "snake, theta": ("kinematic_snake", "theta", (0.4, 1.6)),
    "satellite, theta": ("satellite", "theta", (-1.5, 1.5)),
    "legs, rx": ("legged_satellite", "rx", (0.2, 2.9)),
    "legs, rz": ("legged_satellite", "rz", (0.2, 2.9)),
}


def loop(plane, *series, samples=64):
    """A path (samples, 2) and its rate: rows of cos and sin of 1, 2, ... in parts of the range."""
    size = 0.3 * np.ptp(plane.box, axis=1)
    t = 2 * np.pi * np.arange(samples) / samples
    path, rate = np.tile(plane.box.mean(axis=1), (samples, 1)), np.zeros((samples, 2))
    for k, (cosine, sine) in enumerate(series, start=1):
        c, s = np.cos(k * t)[:, None], np.sin(k * t)[:, None]
        path = path + size * (c * cosine + s * sine)
        rate = rate + k * size * (c * sine - s * cosine)
    return path, rate


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("name", "row"), [("kinematic_snake", 0), ("legged_satellite", 4)])
def test_gradient_of_the_net_motion(name, row, sense):
    plane = ShapePlane(reduction(rr.machines.by_name(name)), (0.4, 1.4), resolution=13)
    gain, circle = _Gain(plane, row, sense), np.array(((1.0, 0.0), (0.0, 1.0)))
    bend = 0.1 * np.random.default_rng(1).normal(size=(2, 2, 2))
    errors = []
    for samples in (64, 256):
        paths = [loop(plane, circle + e * bend[0], e * bend[1], samples=samples)
                 for e in (1e-4, 0.0, -1e-4)]  # fmt: skip
        change = (gain(*paths[0])[0] - gain(*paths[2])[0]) / 2e-4
        moved = (paths[0][0] - paths[2][0]) / 2e-4
        slope = np.sum(gain(*paths[1])[1] * moved)
        errors.append(abs(change / slope - 1))
    # Good to the square of a step, so a sixteenth for a quarter.
    assert errors[1] < 2e-3 and errors[1] < 0.07 * errors[0] + 1e-7


@pytest.mark.parametrize("which", some(BEST, by_default=("snake, x", "satellite, theta")))
@pytest.mark.parametrize("per", [pytest.param("cycle", marks=pytest.mark.slow), "travel"])
def test_no_other_cycle_moves_it_more(which, per):
    name, component, box = BEST[which]
    machine = rr.machines.by_name(name)
    best = rr.machines.optimal_cycle(machine, component, shape_range=box, per=per)
    angles = best.gait(np.linspace(0, 2 * np.pi, 500)).angle
    assert box[0] <= angles.min() and angles.max() <= box[1]
    # The dynamics say the same of it.
    t = machine.simulate(best.gait, best.gait.period, sample_interval=best.gait.period)
    whole = t.pose[-1] if machine.model.planar else np.append(t.pose[-1, :3], t.rotation_vector[-1])
    np.testing.assert_allclose(list(best.moved.values()), whole, atol=1e-8)
    plane = ShapePlane(reduction(machine), box)
    row = list(best.moved).index(component)
    rng = np.random.default_rng(2)
    found = []
    for _ in range(40):
        series = rng.normal(size=(2, 2, 2)) * np.array((1.0, 0.2))[:, None, None]
        path, rate = loop(plane, *series)
        middle = plane.box.mean(axis=1)
        scale = 1 / max(1.0, (np.abs(path - middle) / (np.ptp(plane.box, axis=1) / 2)).max())
        path, rate = middle + scale * (path - middle), scale * rate
        travel = np.linalg.norm(rate, axis=1).mean() * 2 * np.pi
        gain = max(_Gain(plane, row, sense)(path, rate)[0] for sense in (1, -1))
        found.append(gain / (travel if per == "travel" else 1.0))
    assert best.gain / (best.travel if per == "travel" else 1.0) > max(found) > 0


def test_the_most_turn_of_a_satellite_is_nearly_what_its_region_holds():
    body = rr.machines.satellite()
    best = rr.machines.optimal_cycle(body, "theta", shape_range=(0.1, 1.5), harmonics=10)
    plane, n = ShapePlane(reduction(body), (0.1, 1.5)), 121
    x = 0.1 + 1.4 * (np.arange(n) + 0.5) / n
    grid = np.stack(np.meshgrid(x, x, indexing="ij"), -1).reshape(-1, 2)
    heights = plane.curvature(grid)[:, 2].reshape(n, n)
    whole, _, _ = largest_region(x, x, heights, 1e-9)
    assert 0.95 < best.gain / abs(whole) < 1.0


def test_splines_of_the_plane_are_the_connection():
    snake = reduction(rr.machines.kinematic_snake())
    plane = ShapePlane(snake, (0.4, 1.4))
    points = np.random.default_rng(3).uniform(0.45, 1.35, (4, 2))
    for point, A, D in zip(points, plane.connection(points), plane.curvature(points), strict=True):
        np.testing.assert_allclose(A, snake.connection(point), atol=1e-6)
        np.testing.assert_allclose(D, snake.curvature(point), atol=1e-4)


def test_cycles_that_cannot_be_are_refused():
    best = rr.machines.optimal_cycle
    snake = rr.machines.kinematic_snake()
    with pytest.raises(rr.ConstraintError, match=r"as good as singular.*wheels align"):
        best(snake, "x", shape_range=(-1.0, 1.0))
    with pytest.raises(rr.ParameterError, match="must be one of x, y, theta"):
        best(snake, "yaw", shape_range=(0.4, 1.4))
    with pytest.raises(rr.ParameterError, match="low below high"):
        best(snake, "x", shape_range=(1.4, 0.4))
    with pytest.raises(rr.ParameterError, match="two of the 2 motors"):
        best(snake, "x", shape_range=(0.4, 1.4), pair=(0, 2))
    with pytest.raises(rr.ParameterError, match="per is 'second'"):
        best(snake, "x", shape_range=(0.4, 1.4), per="second")
    with pytest.raises(rr.ModelError, match="is mixed"):
        best(rr.machines.trikke(), "x", shape_range=(0.4, 1.4))


def test_maps_of_heights_have_their_panels_and_singular_shapes():
    snake = rr.machines.kinematic_snake()
    figure = rr.figures.curvature_maps(snake, ["x", "theta"], shape_range=(-1, 1), resolution=7)
    panels = [ax for ax in figure.axes if ax.get_title()]
    assert [ax.get_title() for ax in panels] == ["x", "θ"]
    # Wheels align along a1 = -a2.
    red = [
        path.vertices
        for collection in panels[0].collections
        if isinstance(collection, QuadContourSet)
        and np.allclose(collection.get_edgecolor()[:, :3], (0xBB / 255, 0, 0))
        for path in collection.get_paths()
    ]
    assert red and np.abs(red[0].sum(axis=1)).max() < 1e-2
    board = rr.machines.snakeboard()
    folded = np.pi / 2
    figure = rr.figures.curvature_maps(board, ["x"], pair=(1, 2), resolution=5,
                                       shape_range=(folded - 1, folded + 1))  # fmt: skip
    marks = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    np.testing.assert_allclose([m.get_xydata() for m in marks], [[[folded, folded]]], atol=1e-12)
    with pytest.raises(rr.ParameterError, match="each must be of x, y, theta"):
        rr.figures.curvature_maps(snake, ["z"], shape_range=(-1, 1))

"""Bellies: the shell around an underside, how it rests, how far it rolls, what is wrong with it."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import nnls

import rrrobot as rr
from rrrobot.belly.distances import coal_shape
from rrrobot.belly.fitting import cone, fit_form
from rrrobot.belly.placed import Gauge, Touches, placed
from rrrobot.belly.shapes import support
from rrrobot.robot.chains import leg_chains, symmetry_of

LENGTH, WIDTH, HEIGHT, MASS = 0.4, 0.2, 0.1, 5.0
BALL = 0.03


def link(name, mass, inertia, shape, at=(0, 0, 0)):
    place = f'<origin xyz="{at[0]} {at[1]} {at[2]}"/>'
    moments = 'ixx="{}" ixy="0" ixz="0" iyy="{}" iyz="0" izz="{}"'.format(*inertia)
    return (
        f'<link name="{name}"><inertial>{place}<mass value="{mass}"/><inertia {moments}/>'
        f"</inertial><collision>{place}<geometry>{shape}</geometry></collision></link>"
    )


def joint(name, child, at, axis="0 1 0", limits=(-1.0, 1.0)):
    return (
        f'<joint name="{name}" type="revolute"><parent link="base"/><child link="{child}"/>'
        f'<origin xyz="{at[0]} {at[1]} {at[2]}"/><axis xyz="{axis}"/>'
        f'<limit lower="{limits[0]}" upper="{limits[1]}" effort="5" velocity="9"/></joint>'
    )


def board(lift=0.0, arms=True):
    """A box whose centre of mass is `lift` above its middle, with an arm at either side."""
    box = f'<box size="{LENGTH} {WIDTH} {HEIGHT}"/>'
    x, y, z = (MASS / 12 * np.array((LENGTH, WIDTH, HEIGHT)) ** 2).tolist()
    base = link("base", MASS, (y + z, x + z, x + y), box)
    base = base.replace('<inertial><origin xyz="0 0 0"/>', f'<inertial><origin xyz="0 0 {lift}"/>')
    ball = f'<sphere radius="{BALL}"/>'
    parts = [base]
    for side, name in ((1, "left"), (-1, "right")) if arms else ():
        parts.append(link(name, 0.2, (1e-4, 1e-4, 1e-4), ball, (0.15, 0, 0)))
        parts.append(joint(f"{name}_hip", name, (0, side * (WIDTH / 2 + 0.05), 0)))
    return f'<robot name="board">{"".join(parts)}</robot>'


def robot(**options):
    return rr.Robot.from_urdf(board(**options), shell=rr.Sphere(1.0))


def test_a_ball_is_found_as_it_is():
    belly = rr.fit_belly(rr.Robot.from_parameters(), posture=(np.pi / 2, np.pi / 2))
    assert belly.kind == "round" and belly.shell == rr.Sphere(0.12)
    assert np.all(belly.center == 0) and belly.stable and belly.reason == ""
    periods = sorted(m.period for m in belly.modes if np.isfinite(m.period))
    assert periods == pytest.approx([1.07346, 1.29251], abs=1e-5)


def test_a_flat_belly_rocks_on_a_boulder_as_a_board_does():
    # w^2 = g (R - h) / (k^2 + h^2): a board of radius of gyration k, h high, on a ball.
    belly = rr.fit_belly(robot(arms=False), ground=rr.Boulder(0.5))
    h = HEIGHT / 2
    assert belly.kind == "flat" and belly.shell == rr.FlatBelly(*belly.face)
    assert belly.height == pytest.approx(h, abs=1e-12)
    assert belly.face == pytest.approx((LENGTH / 2, WIDTH / 2), rel=0.02)
    assert belly.error < 1e-6
    for axis, side in (("roll", WIDTH), ("pitch", LENGTH)):
        gyration = (side**2 + HEIGHT**2) / 12
        w = np.sqrt(9.81 * (0.5 - h) / (gyration + h**2))
        (mode,) = [m for m in belly.modes if m.axis == axis and np.isfinite(m.period)]
        assert mode.period == pytest.approx(2 * np.pi / w, rel=1e-6)
    reach = belly.rolling_range
    assert reach.at(np.pi / 2) == pytest.approx(belly.face[1] / 0.5, abs=1e-3)
    assert set(reach.link) == {"edge of the belly"}


def test_how_far_short_a_high_belly_is_and_when_it_stands():
    # Stable on a boulder where the centre of mass is lower than the radius.
    h = HEIGHT / 2 + 0.15
    low = rr.fit_belly(robot(lift=0.15, arms=False), ground=rr.Boulder(h - 0.01))
    assert not low.stable and low.margin == pytest.approx([-0.01, -0.01], abs=1e-9)
    assert "10 mm above the centre of curvature" in low.reason and "larger boulder" in low.reason
    high = rr.fit_belly(robot(lift=0.15, arms=False), ground=rr.Boulder(h + 0.01))
    assert high.stable and high.reason == "" and high.modes[0].decay_rate > -1e-6


@pytest.mark.parametrize("form", ["sphere", "ellipsoid", "box"])
def test_the_dome_holds_the_underside_and_none_near_it_does_better(form):
    pieces = rr.belly.Shapes.of(robot()).on_joint(1)
    tilt = 0.25

    def body(u):
        return support(pieces, u)

    fit = fit_form(form, body, tilt)
    fine = cone(tilt, 20, 96)

    def gap(shell, center):
        return np.array([shell.support(u) for u in fine]) + fine @ center - body(fine)

    own = gap(fit.shell, fit.center)
    assert own.min() > -5e-3 * fit.error and own.max() == pytest.approx(fit.error, rel=0.02)
    rng = np.random.default_rng(0)
    for _ in range(60):
        scale = np.exp(rng.normal(0, 0.05))
        shell = {
            "sphere": lambda s: rr.Sphere(s * fit.shell.radius),
            "ellipsoid": lambda s: rr.Ellipsoid(tuple(s * np.array(fit.shell.semi_axes))),
            "box": lambda s: rr.EllipsoidSum(list(s * np.array(fit.shell.semi_axes))),
        }[form](scale)
        other = gap(shell, fit.center + rng.normal(0, 0.005, 3))
        # Moved down until it holds everything.
        other += other.min() / fine[:, 2] - 0.0
        assert other.max() > 0.97 * fit.error


def test_the_range_ends_where_an_arm_touches():
    # An arm's ball at (x, z) touches when x sin t - z cos t + its radius = the shell's radius.
    radius = 0.11
    text = board().replace(
        f'<box size="{LENGTH} {WIDTH} {HEIGHT}"/>', f'<sphere radius="{radius}"/>'
    )
    angle = 0.2
    belly = rr.fit_belly(rr.Robot.from_urdf(text, shell=rr.Sphere(1.0)), posture=angle)
    assert belly.kind == "round" and belly.shell == rr.Sphere(radius)
    x, z = 0.15 * np.cos(angle), -0.15 * np.sin(angle)
    far = np.hypot(x, z)
    wanted = np.arcsin((radius - BALL) / far) - np.arctan2(-z, x)
    y = WIDTH / 2 + 0.05
    tilts = np.linspace(0, 1, 200001)
    for azimuth in (0.0, np.pi / 4):
        across = x * np.cos(azimuth) + y * abs(np.sin(azimuth))
        depth = across * np.sin(tilts) - z * np.cos(tilts) + BALL - radius
        wanted = tilts[np.argmax(depth > 5e-4)]
        assert belly.rolling_range.at(azimuth) == pytest.approx(wanted, abs=2e-4)
    assert belly.rolling_range.link[0] in ("left", "right")


def test_postures_clear_the_ground_and_keep_their_symmetry():
    belly = rr.fit_belly(robot(), ground=rr.Boulder(0.8))
    assert belly.posture[0] == belly.posture[1] and belly.clearance > 0
    assert belly.robot.joints.lower[0] <= belly.posture[0] <= belly.robot.joints.upper[0]
    # Arms as low as their room allows: a lower posture is not clear.
    assert belly.clearance < 0.03
    lower = rr.fit_belly(robot(), ground=rr.Boulder(0.8), posture=belly.posture + 0.3)
    assert lower.clearance < 0 and "in the ground" in lower.reason


def test_distances_from_ground_are_those_of_coal():
    import coal

    shapes = rr.belly.Shapes.of(robot())
    pieces = placed(robot(), shapes.pieces, np.array((0.4, -0.7)))
    rng = np.random.default_rng(1)
    normal = rng.normal(size=3) * 0.2 + (0, 0, -1)
    normal /= np.linalg.norm(normal)
    point = np.array((0.02, -0.03, -0.3))
    half = coal.Halfspace(-normal, float(-normal @ point))
    found = Gauge(pieces, 0.0)(Touches(point[None], normal[None], 0.0))[0]
    for gap, piece in zip(found, pieces, strict=True):
        shape, place = coal_shape(piece)
        at = coal.Transform3s(place.rotation, place.translation)
        result = coal.DistanceResult()
        wanted = coal.distance(shape, at, half, coal.Transform3s(), coal.DistanceRequest(), result)
        assert gap == pytest.approx(wanted, abs=1e-9)
    # From a ball, by the least squares of convex combinations of the corners.
    point[2] = -0.08
    ball = Gauge(pieces, 1 / 0.3)(Touches(point[None], normal[None], 1 / 0.3))[0]
    middle = point + 0.3 * normal
    for gap, piece in zip(ball, pieces, strict=True):
        rows = np.vstack((piece.points.T - middle[:, None], np.full(len(piece.points), 1e3)))
        wanted = nnls(rows, np.array((0, 0, 0, 1e3)))[1] - piece.radius - 0.3
        assert gap == pytest.approx(wanted, abs=1e-5)
    # In a bowl the farthest corner from its centre is the nearest to the ground.
    bowl = Gauge(pieces, -1 / 0.7)(Touches(point[None], normal[None], -1 / 0.7))[0]
    for gap, piece in zip(bowl, pieces, strict=True):
        away = np.linalg.norm(piece.points - (point - 0.7 * normal), axis=1).max()
        assert gap == pytest.approx(0.7 - away - piece.radius, abs=1e-12)


def test_capsules_hold_their_pieces():
    shapes = rr.belly.Shapes.of(rr.Robot.from_example("solo12", shell=rr.Sphere(0.3)))
    for piece, (_, a, b, radius) in zip(shapes.pieces, shapes.capsules, strict=True):
        along = (piece.points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12)
        foot = a + np.clip(along, 0, 1)[:, None] * (b - a)
        away = np.linalg.norm(piece.points - foot, axis=1) + piece.radius
        assert away.max() <= radius + 1e-9


def test_limbs_and_their_images():
    solo = rr.Robot.from_example("solo12", shell=rr.Sphere(0.3))
    assert leg_chains(solo) == ((0, 1, 2), (3, 4, 5), (6, 7, 8), (9, 10, 11))
    mirror = symmetry_of(solo, "left-right")
    angle = np.random.default_rng(0).uniform(-1, 1, 12)
    model = solo.model
    data = [model.createData(), model.createData()]
    for d, a in zip(data, (angle, mirror.image(angle)), strict=True):
        pin.centerOfMass(model, d, np.concatenate((pin.neutral(model)[:7], a)))
    # The whole robot's centre of mass mirrors, but for the base's own misprints of a few mm.
    assert data[1].com[0] == pytest.approx(data[0].com[0] * (1, -1, 1), abs=2e-3)
    assert symmetry_of(rr.Robot.from_example("bolt", shell=rr.Sphere(0.3)), "front-back") is None
    # Legs that mirror each other but for their knees, which all bend one way.
    b1 = rr.Robot.from_example("b1", shell=rr.Sphere(0.3))
    assert symmetry_of(b1, "left-right") is not None and symmetry_of(b1, "front-back") is None


def test_a_real_robot_on_a_rock_and_on_the_floor():
    rock = rr.fit_belly("solo12", ground=rr.Boulder(0.4))
    assert rock.kind == "flat" and rock.stable and rock.reason == "" and rock.error < 1e-3
    assert rock.separation > 0 and rock.clearance > 0
    assert {m.axis for m in rock.modes if np.isfinite(m.period)} == {"roll", "pitch"}
    floor = rr.fit_belly("solo12")
    assert floor.kind == "dome" and floor.reason == "" and 5e-3 < floor.thickness < 2.5e-2
    assert "FL_SHOULDER" in floor.covered
    assert floor.rolling_range.least == pytest.approx(np.deg2rad(15))
    # The gait of a robot with this belly is simulated as any other.
    model = floor.model()
    t = rr.simulate(model, rr.StillLegs(floor.posture), 0.2, euler=(0.02, 0, 0), start="rest")
    assert t.slip.max() < 1e-12
    assert rr.Robot.from_dict(floor.robot.to_dict()) == floor.robot
    figure = floor.plot()[0].figure
    assert len(figure.axes) == 2


@pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")
def test_links_and_joints_may_share_names_when_joints_are_locked():
    # ANYmal C has a link and a joint LF_HFE; Pinocchio's own reduction takes one for the other.
    whole = rr.Robot.from_example("anymal_c", shell=rr.Sphere(0.4))
    legs = ("LF_HFE", "RF_HFE")
    held = rr.Robot.from_example("anymal_c", shell=rr.Sphere(0.4), legs=legs)
    assert held.legs == legs and len(held.locked) == 10
    q = pin.neutral(whole.model)
    q[7 + whole.legs.index("LF_HFE")] = 0.3
    own = np.concatenate((q[:7], (0.3, 0.0)))
    centers = [
        pin.centerOfMass(robot.model, robot.model.createData(), at)
        for robot, at in ((whole, q), (held, own))
    ]
    assert centers[0] == pytest.approx(centers[1], abs=1e-12)


def test_bad_bellies_are_named(tmp_path):
    plain = board().replace("<collision>", "<sensor>").replace("</collision>", "</sensor>")
    bare = rr.Robot.from_urdf(plain, shell=rr.Sphere(1.0))
    with pytest.raises(rr.ShellError, match="base of board has no collision or visual shape"):
        rr.fit_belly(bare)
    with pytest.raises(rr.ParameterError, match="form is 'cube'"):
        rr.fit_belly(robot(), form="cube")
    with pytest.raises(rr.ParameterError, match="at most 60 degrees"):
        rr.fit_belly(robot(), tilt=1.2)
    with pytest.raises(rr.ShellError, match="rolls on a Boulder"):
        rr.fit_belly(robot(), form="flat")
    with pytest.raises(rr.UrdfError, match="there is no URDF file 'solo13'"):
        rr.fit_belly("solo13")
    lost = board().replace(f'<box size="{LENGTH} {WIDTH} {HEIGHT}"/>', '<mesh filename="no.stl"/>')
    with pytest.raises(rr.ShellError, match=r"'no.stl' is not found"), pytest.warns(rr.UrdfWarning):
        rr.fit_belly(rr.Robot.from_urdf(lost, shell=rr.Sphere(1.0)))
    broken = tmp_path / "broken.stl"
    broken.write_bytes(b"no triangles")
    text = lost.replace("no.stl", str(broken))
    with pytest.raises(rr.ShellError) as told, pytest.warns(rr.UrdfWarning):
        rr.fit_belly(rr.Robot.from_urdf(text, shell=rr.Sphere(1.0)))
    assert "broken.stl' cannot be read (Could not load" in str(told.value)
    assert "in function" not in str(told.value) and "package_dirs=" in str(told.value)
    thin = board().replace(
        f'<box size="{LENGTH} {WIDTH} {HEIGHT}"/>', '<box size="0.4 0.001 0.1"/>'
    )
    with pytest.raises(rr.ShellError, match="1 mm wide: no belly fits an underside"):
        rr.fit_belly(rr.Robot.from_urdf(thin, shell=rr.Sphere(1.0)))
    tight = rr.fit_belly(robot(arms=False), ground=rr.Boulder(-0.3), form="sphere")
    assert "curves tighter than the shell" in tight.reason and not tight.stable


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")
@pytest.mark.parametrize("name", ["solo8", "anymal", "anymal_c", "a1", "go1", "b1", "laikago"])
def test_every_quadruped_has_a_belly(name):
    for ground in (None, rr.Boulder(0.4)):
        belly = rr.fit_belly(name, ground=ground)
        assert belly.stable and belly.reason == "", (name, ground, belly.reason)
        assert belly.rolling_range.least > np.deg2rad(3)
        assert belly.margin.min() > 0.1 and belly.separation > 0 and belly.clearance > 0


def test_an_own_shell_is_taken_where_it_is():
    """A dome of a radius, its lowest point so far below the flat underside, off the middle."""
    radius, below, aside = 0.8, 0.005, (0.01, -0.005)
    center = (*aside, radius - below - HEIGHT / 2)
    own = rr.Robot.from_urdf(board(arms=False), shell=rr.Sphere(radius), shell_center=center)
    belly = rr.fit_belly(own, form="own")
    assert belly.kind == "dome" and belly.form == "own" and belly.shell == own.shell
    assert belly.center == pytest.approx(center, abs=1e-15)
    assert belly.thickness == pytest.approx(below, abs=1e-12)
    # Where a tilt (rolled from below the centre) brings a corner to the ground.
    corner = np.array((LENGTH, WIDTH)) / 2
    for azimuth, half, at in zip((0.0, np.pi / 2), corner, aside, strict=True):
        end = belly.rolling_range.at(azimuth)
        reach = radius - (half - at) * np.sin(end) - (radius - below) * np.cos(end)
        assert reach == pytest.approx(-5e-4, abs=2e-5), azimuth
    # Of a ball that is the robot's own, the fit and the own shell are the same.
    ball = rr.Robot.from_parameters()
    fitted, same = rr.fit_belly(ball, posture=1.5), rr.fit_belly(ball, form="own", posture=1.5)
    assert same.kind == "round" and [m.period for m in same.modes] == [
        m.period for m in fitted.modes
    ]
    assert same.rest == pytest.approx(fitted.rest, abs=1e-12)


def test_an_own_shell_that_is_none_is_refused():
    turned = rr.Robot.from_urdf(board(), shell=rr.Ellipsoid((1, 2, 3)), shell_rpy=(0, 0, 0.1))
    flat = rr.Robot.from_urdf(board(), shell=rr.FlatBelly(0.2, 0.1), shell_center=(0, 0, -0.05))
    for own, said in ((turned, "turned against"), (flat, "is flat"), (board(), "of a Robot")):
        with pytest.raises(rr.ShellError, match=said):
            rr.fit_belly(own, form="own", ground=rr.Boulder(1.0))

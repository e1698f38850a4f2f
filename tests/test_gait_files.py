"""Gaits as files: samples, JSON, set-points, ROS messages."""

import json

import numpy as np
import pytest
import yaml

import rrrobot as rr
from rrrobot.drive import write_gait

CIRCULAR = rr.gait("circular")


def samples(n, gait=CIRCULAR):
    time = np.linspace(0.0, gait.period, n)
    return time, gait(time).angle


def test_spline_converges_with_the_fourth_power():
    at = np.linspace(-1.0, 3.0, 997)

    def error(n):
        return np.abs(rr.SampledGait(*samples(n))(at).angle - CIRCULAR(at).angle).max()

    assert error(81) < 1e-6
    assert error(41) / error(81) == pytest.approx(16, rel=0.2)


def test_derivatives_are_those_of_the_angle():
    gait = rr.SampledGait(*samples(41))
    at, h = np.linspace(0.01, 2.0, 57), 1e-5
    rate = (gait(at + h).angle - gait(at - h).angle) / (2 * h)
    acceleration = (gait(at + h).rate - gait(at - h).rate) / (2 * h)
    np.testing.assert_allclose(gait(at).rate, rate, atol=1e-8)
    np.testing.assert_allclose(gait(at).acceleration, acceleration, atol=1e-3)


def test_seam_is_as_smooth_as_the_rest():
    gait = rr.SampledGait(*samples(41))
    before, after = gait(gait.period - 1e-10), gait(gait.period + 1e-10)
    for low, high in zip(before, after, strict=True):
        np.testing.assert_allclose(low, high, atol=1e-6)


def test_cycle_that_does_not_close_is_refused():
    time, angle = samples(41)
    with pytest.raises(rr.GaitError, match="closes the cycle"):
        rr.SampledGait(time[:-1], angle[:-1])


def test_legs_may_go_round_and_round():
    time = np.linspace(0.0, 2.0, 21)
    gait = rr.SampledGait(time, np.pi * time[:, None])
    np.testing.assert_allclose(gait(7.3).angle, 7.3 * np.pi, rtol=1e-12)
    np.testing.assert_allclose(gait(7.3).rate, np.pi, rtol=1e-12)
    assert gait.period == 2.0


def test_once_starts_and_ends_at_rest():
    time = np.linspace(0.0, 1.0, 11)
    gait = rr.SampledGait(time, np.column_stack((time, time**2)), periodic=False)
    assert gait.period is None
    for at in (0.0, 1.0, 5.0):
        np.testing.assert_allclose(gait(at).rate, 0.0, atol=1e-12)
    np.testing.assert_allclose(gait(5.0).angle, (1.0, 1.0))


@pytest.mark.parametrize(
    ("time", "angle", "message"),
    [
        ([0, 1, 1, 2], np.zeros((4, 2)), "must rise"),
        ([0, 1, 2], np.zeros((3, 2)), "3 samples"),
        ([0, 1, 2, 3], np.zeros(4), "shape"),
        ([0, 1, 2, np.nan], np.zeros((4, 2)), "finite"),
    ],
)
def test_bad_samples_are_refused(time, angle, message):
    with pytest.raises(rr.GaitError, match=message):
        rr.SampledGait(time, angle)


@pytest.mark.slow
def test_samples_simulate_as_the_gait_they_are_of():
    model = rr.FullModel(rr.Robot.from_parameters())
    true = rr.simulate(model, CIRCULAR, 2.0)
    ours = rr.simulate(model, rr.SampledGait(*samples(201)), 2.0)
    np.testing.assert_allclose(ours.position, true.position, atol=1e-6)


@pytest.mark.parametrize(
    "gait",
    [
        CIRCULAR,
        rr.StillLegs((1.0, 1.5)),
        rr.FourierGait(
            offset=(1, 2), cosine=[[0.1, 0.2]], sine=[[0.3, 0.1]], angular_frequency=7.0
        ),
        rr.RampIn(CIRCULAR, 1.5),
        rr.SampledGait(*samples(21)),
    ],
    ids=lambda gait: type(gait).__name__,
)
def test_every_gait_comes_back_from_its_file(gait, tmp_path):
    back = rr.read_gait(write_gait(gait, tmp_path / "gait.json"))
    assert back.to_dict() == gait.to_dict()
    at = np.linspace(0.0, 3.0, 31)
    np.testing.assert_array_equal(back(at).acceleration, gait(at).acceleration)


def test_csv_may_have_a_head_and_remarks(tmp_path):
    path = tmp_path / "gait.csv"
    rows = "\n".join(f"{t},{a},{b}" for t, (a, b) in zip(*samples(41), strict=True))
    path.write_text(f"# by hand\ntime,left,right\n{rows}\n")
    np.testing.assert_array_equal(rr.read_gait(path).angle, samples(41)[1])


def test_set_points_are_read_again_and_units_in_heads_count(tmp_path):
    gait = rr.gait("circular")
    table = rr.gait_table(gait, 100.0)
    back = rr.read_gait(table.to_csv(tmp_path / "points.csv"))
    np.testing.assert_allclose(back(0.1234).angle, gait(0.1234).angle, atol=1e-7)
    degrees = np.column_stack((1e3 * table.time, np.rad2deg(table.angle)))
    degrees[-1, 1] += 1e-4  # a log that closes as well as logs do
    head = "time [ms],left [deg],right [deg]"
    np.savetxt(tmp_path / "log.csv", degrees, delimiter=",", header=head, comments="")
    again = rr.read_gait(tmp_path / "log.csv")
    assert again.period == pytest.approx(gait.period, rel=1e-12)
    np.testing.assert_allclose(again(0.1234).angle, gait(0.1234).angle, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("h.csv", "time [s],left [grad]\n0,1\n", "unit of 'left .grad.' is none of rad"),
        ("i.csv", "time [h],left\n0,1\n", "unit of 'time .h.' is none of s, ms"),
        ("j.csv", "time,left\n0,1,2\n", "2 names for 3 columns"),
        ("k.json", '{"type": "sinusoidal", "offset": 1}', "lacks the entry amplitude, angular"),
        ("l.json", '{"type": "still", "angle": [1], "foo": 2}', "does not know the entry foo"),
        ("a.csv", "time,left\n0,zero\n", "no table of numbers"),
        ("b.csv", "0\n1\n2\n3\n", "no column of angles"),
        ("c.csv", "0,1\n1,2,3\n", "no table of numbers"),
        ("d.json", '{"type": "trot"}', "trot"),
        ("e.json", "[1, 2", "cannot read"),
        ("f.json", '{"type": "sinusoidal", "offset": 1}', "cannot read"),
        ("g.json", '{"type": "plane"}', "gait type"),
    ],
)
def test_files_that_are_no_gait_are_refused_in_a_sentence(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(rr.GaitError, match=message):
        rr.read_gait(tmp_path / name)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(rr.GaitError, match="nowhere"):
        rr.read_gait(tmp_path / "nowhere.json")


def test_table_of_one_period_closes_and_can_be_played_again():
    table = rr.gait_table(CIRCULAR, 50.0)
    np.testing.assert_allclose(table.angle[-1], table.angle[0], atol=1e-12)
    assert (len(table.time) - 1) / table.rate_hz == pytest.approx(CIRCULAR.period, rel=1e-14)
    assert abs(table.rate_hz - 50.0) < 1 / CIRCULAR.period
    np.testing.assert_array_equal(table.rate, CIRCULAR(table.time).rate)


def test_table_of_a_duration_keeps_the_rate():
    table = rr.gait_table(rr.StillLegs((1, 2)), 100.0, duration=0.5)
    assert len(table.time) == 51 and table.rate_hz == 100.0
    with pytest.raises(rr.GaitError, match="duration"):
        rr.gait_table(rr.StillLegs((1, 2)), 100.0)


def test_set_points_go_back_in_as_samples(tmp_path):
    table = rr.gait_table(CIRCULAR, 100.0)
    path = table.to_csv(tmp_path / "points.csv")
    read = np.loadtxt(path, delimiter=",", skiprows=1)
    np.testing.assert_array_equal(read[:, 1:3], table.angle)
    assert read.shape[1] == 7
    head = path.read_text().splitlines()[0].split(",")
    assert head[:2] == ["time [s]", "leg_1_angle [rad]"] and head[-1].endswith("[rad/s^2]")
    same = json.loads(table.to_json(tmp_path / "points.json").read_text())
    assert list(same) == head
    np.testing.assert_array_equal(np.column_stack(list(same.values())), read)
    slid = rr.gait_table(CIRCULAR, 50.0, slides=(True, False))
    assert "leg_1_rate [m/s]" in slid.columns and "leg_2_rate [rad/s]" in slid.columns


def test_ros_message_has_the_message_s_fields_and_times(tmp_path):
    table = rr.gait_table(CIRCULAR, 50.0, duration=2.5, joints=("left", "right"))
    message = yaml.safe_load(table.to_ros(tmp_path / "a.yaml").read_text())
    assert message == json.loads(table.to_ros(tmp_path / "a.json").read_text())
    assert set(message) == {"header", "joint_names", "points"}
    assert message["joint_names"] == ["left", "right"]
    stamps = [p["time_from_start"] for p in message["points"]]
    seconds = np.array([s["sec"] + 1e-9 * s["nanosec"] for s in stamps])
    np.testing.assert_allclose(seconds, table.time, atol=1e-9)
    assert all(0 <= s["nanosec"] < 10**9 and type(s["sec"]) is int for s in stamps)
    np.testing.assert_array_equal([p["velocities"] for p in message["points"]], table.rate)
    point = {"positions", "velocities", "accelerations", "effort", "time_from_start"}
    assert all(set(p) == point for p in message["points"])

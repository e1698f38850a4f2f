"""A trajectory in other programs' formats: what comes back is what went out, to the last bit."""

import csv
import json

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.io import loadmat

import rrrobot as rr
from rrrobot.simulation.export import QUANTITIES

SLIDER = """<robot name="slider"><link name="body"><inertial><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="weight"><inertial><origin xyz="0 0 -0.02"/><mass value="0.2"/>
<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="rail" type="prismatic"><parent link="body"/><child link="weight"/><axis xyz="1 0 0"/>
<limit lower="-0.1" upper="0.1" effort="1" velocity="1"/></joint></robot>"""


@pytest.fixture(scope="module")
def run():
    return rr.simulate(rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular"), 1.0)


@pytest.fixture(scope="module")
def sliding_run():
    robot = rr.Robot.from_urdf(SLIDER, shell=rr.Sphere(0.1))
    gait = rr.SinusoidalGait(offset=0.0, amplitude=0.02, angular_frequency=6.0, n_legs=1)
    return rr.simulate(rr.FullModel(robot), gait, 0.5)


def test_dataset_holds_every_array_with_its_unit(run):
    ds = run.to_dataset()
    for name in QUANTITIES:
        np.testing.assert_array_equal(ds[name].to_numpy(), getattr(run, name))
        assert ds[name].attrs["description"]
    np.testing.assert_array_equal(ds.time, run.time)
    assert ds.leg_torque.attrs["units"] == "N m"
    assert ds.contact_force.attrs["frame"] == "world"
    assert float(ds.leg_angle.sel(leg="leg_2")[-1]) == run.leg_angle[-1, 1]
    assert json.loads(ds.attrs["gait"]) == run.metadata["gait"]


def test_no_array_of_a_trajectory_stays_behind(run):
    arrays = {k for k, v in vars(run).items() if isinstance(v, np.ndarray)}
    assert arrays <= set(QUANTITIES) | {"time", "memory"}


def test_dataset_goes_through_netcdf(run, tmp_path):
    run.to_dataset().to_netcdf(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as back:
        np.testing.assert_array_equal(back.euler.to_numpy(), run.euler)
        assert back.energy.attrs["units"] == "J"


def test_csv_reads_back_bit_for_bit(run, tmp_path):
    path = run.to_csv(tmp_path / "run.csv")
    with path.open() as stream:
        head, *rows = csv.reader(stream)
    table = np.array(rows, dtype=float)
    columns = dict(zip(head, table.T, strict=True))
    np.testing.assert_array_equal(columns["time [s]"], run.time)
    np.testing.assert_array_equal(columns["yaw_rate [rad/s]"], run.euler_rates[:, 2])
    np.testing.assert_array_equal(columns["leg_2_torque [N m]"], run.leg_torque[:, 1])
    np.testing.assert_array_equal(columns["base_qw [1]"], run.configuration[:, 6])


def test_pandas_and_csv_are_one_table(run, tmp_path):
    frame = run.to_pandas()
    units = frame.attrs["units"]
    read = pd.read_csv(run.to_csv(tmp_path / "run.csv"), index_col=0)
    assert list(read.columns) == [f"{name} [{units[name]}]" for name in frame.columns]
    # pandas' own reader is one bit off now and then.
    np.testing.assert_allclose(read.to_numpy(), frame.to_numpy(), rtol=1e-15)
    np.testing.assert_allclose(read.index, frame.index, rtol=1e-15)


def test_matlab_file_holds_arrays_and_units(run, tmp_path):
    back = loadmat(run.to_mat(tmp_path / "run.mat"), simplify_cells=True)
    for name in ("time", *QUANTITIES):
        np.testing.assert_array_equal(back[name], getattr(run, name))
    assert back["units"]["contact_force"] == "N"
    assert back["frame"]["velocity"] == "base"
    assert list(back["legs"]) == ["leg_1", "leg_2"]
    assert json.loads(back["about"]["gait"]) == run.metadata["gait"]


def test_sliding_legs_have_metres_and_newtons(sliding_run):
    units = sliding_run.to_pandas().attrs["units"]
    assert units["rail_angle"] == "m"
    assert units["rail_torque"] == "N"
    assert sliding_run.to_dataset().leg_rate.attrs["units"] == "m/s"


@pytest.mark.parametrize("write", ["to_csv", "to_mat"])
def test_wrong_endings_are_refused(run, tmp_path, write):
    with pytest.raises(rr.OutputError, match="ends in"):
        getattr(run, write)(tmp_path / "run.txt")
    assert not list(tmp_path.iterdir())

"""Whatever is saved can be loaded: sweeps, optimised gaits, fronts, with classes of one's own."""

import json

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.studies import OptimisedGait, ParetoFront, load_sweep, model_of

MODEL = rr.FullModel(rr.Robot.from_parameters(), damping=rr.BodyRateDamping(0.01, 0.02, 0.03))
SMALL = {"amplitude": 0.3, "angular_frequency": 8.0, "budget": 150, "settle_time": 6.0}


@pytest.fixture(scope="module")
def best():
    goal = rr.TightestTurn(min_speed=0.002)
    return rr.optimise(MODEL, goal, limits=rr.GaitLimits(max_variation=0.5), **SMALL)


def test_an_optimised_gait_comes_back(best, tmp_path):
    again = OptimisedGait.load(best.save(tmp_path / "best.json"))
    assert again.to_dict() == best.to_dict()
    np.testing.assert_array_equal(again.trajectory.euler, best.trajectory.euler)
    assert again.goal == best.goal and again.limits == best.limits
    assert rr.read_gait(tmp_path / "best.json").to_dict() == best.gait.to_dict()


def test_a_front_comes_back(tmp_path):
    front = rr.pareto_front(MODEL, n_points=2, limits=rr.GaitLimits(max_variation=0.5), **SMALL)
    again = ParetoFront.load(front.save(tmp_path / "front.json"))
    assert again.to_dict() == front.to_dict()
    np.testing.assert_array_equal(again.cost, front.cost)


@pytest.mark.parametrize("decoupled", [False, True])
def test_a_sweep_comes_back_with_its_model(decoupled, tmp_path):
    model = rr.models.recombined.DecoupledModels(MODEL.robot) if decoupled else MODEL
    path = tmp_path / "sweep.nc"
    made = rr.sweep(model, offset=[0.8, 1.2, 1.5], cycles=4, store=path)
    again = load_sweep(path)
    assert again.drop_vars("status").equals(made.drop_vars("status")) and "checksum" not in again
    assert model_of(again).to_dict() == model.to_dict()
    one = rr.sweep(model_of(again), offset=[1.2], cycles=4)
    assert float(one.speed[0]) == float(again.speed[1])


def test_classes_of_ones_own_come_back(tmp_path):
    @rr.register("paddle")
    class Paddle(rr.Gait):
        """One leg goes round, faster and slower."""

        def __init__(self, rate):
            self.rate, self.n_legs, self.period = rate, 2, 2 * np.pi / rate

        def __call__(self, time):
            u = self.rate * np.asarray(time, dtype=float)
            w, zero = self.rate, 0.0 * u
            return rr.drive.LegMotion(
                np.stack((u + 0.2 * np.sin(u), 1.0 + zero), axis=-1),
                np.stack((w * (1 + 0.2 * np.cos(u)), zero), axis=-1),
                np.stack((-w * w * 0.2 * np.sin(u), zero), axis=-1),
            )

        def to_dict(self):
            return {"type": "paddle", "rate": self.rate}

    @rr.register("slow goal")
    class Slow(rr.studies.FastestTravel):
        name = "slow goal"

    gait = rr.drive.write_gait(Paddle(3.0), tmp_path / "paddle.json")
    ds = rr.sweep(MODEL, points=[rr.read_gait(gait)], cycles=12, store=tmp_path / "own.nc")
    assert load_sweep(tmp_path / "own.nc").winding.values.tolist() == [[1.0, 0.0]]
    assert float(ds.status[0]) == 0
    own = rr.optimise(MODEL, Slow(), limits=rr.GaitLimits(max_variation=1.0), **SMALL)
    assert isinstance(OptimisedGait.load(own.save(tmp_path / "slow.json")).goal, Slow)


def test_what_is_no_result_is_refused(best, tmp_path):
    path = best.save(tmp_path / "best.json")
    with pytest.raises(rr.OutputError, match=r"ends in \.json"):
        best.save(tmp_path / "best.txt")
    for damage in ("", "[]", "{}", json.dumps(json.loads(path.read_text()) | {"goal": {}})):
        path.write_text(damage)
        with pytest.raises(rr.OutputError, match="not what an optimiser of"):
            OptimisedGait.load(path)
        with pytest.raises(rr.OutputError, match="not the netCDF file of a sweep"):
            load_sweep(path)
    with pytest.raises(rr.OutputError, match="there is no file"):
        load_sweep(tmp_path / "none.nc")


@pytest.mark.parametrize("key", ["cycles", "history", "search", "discrepancy", "met"])
def test_a_file_without_a_part_is_refused_by_its_name(best, tmp_path, key):
    path = best.save(tmp_path / "best.json")
    data = json.loads(path.read_text())
    del data[key]
    path.write_text(json.dumps(data))
    with pytest.raises(rr.OutputError, match=f"it has no '{key}'"):
        rr.studies.OptimisedGait.load(path)


def test_a_damaged_gait_of_a_sweep_is_nan(tmp_path):
    path = tmp_path / "two.nc"
    made = rr.sweep(MODEL, offset=[0.8, 1.2], cycles=4, store=path)
    data = bytearray(path.read_bytes())
    place = bytes(np.array(made.speed.values[1], ">f8").tobytes())
    assert data.count(place) == 1
    data[data.index(place) + 7] ^= 1
    path.write_bytes(data)
    with pytest.warns(UserWarning, match="1 of 2 gaits in .* are damaged"):
        again = load_sweep(path)
    assert again.status.values.tolist() == [0, -1] and np.isnan(again.speed[1])
    assert float(again.speed[0]) == float(made.speed[0])

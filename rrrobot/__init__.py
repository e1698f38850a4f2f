"""rrrobot: legless locomotion of round robots. See README.md."""

from rrrobot.closed_forms import (
    composite_period,
    pitch_response,
    rolling_pendulum_period,
    simple_pendulum_period,
    static_pitch,
    yaw_mass_matrix,
)
from rrrobot.compare import (
    Comparison,
    compare,
    matching_yaw_amplitude,
    yaw_drift,
)
from rrrobot.constraints import (
    ConstraintRows,
    KKTSolution,
    KKTSystem,
    PrescribedJoints,
    RollingContact,
    contact_drift,
    contact_jacobian,
    contact_point,
    kkt_build,
    kkt_solve,
    projected_acceleration,
    rolling_null_space,
    rolling_projector,
)
from rrrobot.cycles import OptimalCycle, optimal_cycle
from rrrobot.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.decoupled import decoupled
from rrrobot.errors import (
    ConstraintError,
    GaitError,
    GroundClearanceWarning,
    MissingExtraError,
    ModelError,
    OutputError,
    ParameterError,
    RRRobotError,
    ShellError,
    SimulationError,
    SimulationInterrupted,
    SweepInterrupted,
    UrdfError,
)
from rrrobot.example_robots import example_robots
from rrrobot.gaits import (
    CallableGait,
    FourierGait,
    Gait,
    LegMotion,
    RampIn,
    SinusoidalGait,
    StillLegs,
    gait,
)
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.optimise import optimise
from rrrobot.optimise_goals import FastestTravel, LeastEffort, TargetMotion, TightestTurn
from rrrobot.optimise_pareto import ParetoFront, pareto_front
from rrrobot.optimise_result import OptimisedGait, gait_from_dict
from rrrobot.optimise_table import GaitLimits
from rrrobot.oscillations import (
    Mode,
    PeriodRow,
    equilibrium,
    measured_period,
    modes,
    table_3,
)
from rrrobot.parameters import RRRobotParameters
from rrrobot.reduction import Connection, rotation_connection
from rrrobot.reduction_checks import (
    Controllability,
    Reducibility,
    controllability,
    path_controllability,
    reducibility,
    weightless,
)
from rrrobot.reduction_heights import height_grid, zero_set
from rrrobot.reduction_paths import LegMoves, one_leg_gait, out_of_phase_gait
from rrrobot.reduction_yaw import net_yaw
from rrrobot.reproduction.run import reproduce
from rrrobot.robot import Robot
from rrrobot.rolling import contact_path, contact_velocity, sphere_contact_rate
from rrrobot.simulate import simulate
from rrrobot.steady_state import SteadyState
from rrrobot.surfaces import Ellipsoid, Sphere, Surface
from rrrobot.sweep import sweep
from rrrobot.sweep_models import DecoupledModels
from rrrobot.table4 import Table4, table_4
from rrrobot.torques import LegTorques, MotionState
from rrrobot.trajectory import Trajectory
from rrrobot.urdf import reduced_urdf, rrrobot_urdf, urdf_path
from rrrobot.viewer import Viewer, record
from rrrobot.yaw_planner import YawPlan, plan_yaw

__all__ = [
    "BodyRateDamping",
    "CallableGait",
    "Comparison",
    "Connection",
    "ConstraintError",
    "ConstraintRows",
    "Controllability",
    "Damping",
    "DecoupledModels",
    "Ellipsoid",
    "EulerRateDamping",
    "FastestTravel",
    "FourierGait",
    "FullModel",
    "Gait",
    "GaitError",
    "GaitLimits",
    "GroundClearanceWarning",
    "KKTSolution",
    "KKTSystem",
    "LeastEffort",
    "LegMotion",
    "LegMoves",
    "LegTorques",
    "MissingExtraError",
    "Mode",
    "ModelError",
    "MotionState",
    "OptimalCycle",
    "OptimisedGait",
    "OutputError",
    "ParameterError",
    "ParetoFront",
    "PeriodRow",
    "PitchModel",
    "PivotingModel",
    "PrescribedJoints",
    "RRRobotError",
    "RRRobotParameters",
    "RampIn",
    "Reducibility",
    "Robot",
    "RollModel",
    "RollingContact",
    "ShellError",
    "SimulationError",
    "SimulationInterrupted",
    "SinusoidalGait",
    "Sphere",
    "SteadyState",
    "StillLegs",
    "Surface",
    "SweepInterrupted",
    "Table4",
    "TargetMotion",
    "TightestTurn",
    "Trajectory",
    "UrdfError",
    "Viewer",
    "YawModel",
    "YawPlan",
    "compare",
    "composite_period",
    "contact_drift",
    "contact_jacobian",
    "contact_path",
    "contact_point",
    "contact_velocity",
    "controllability",
    "decoupled",
    "equilibrium",
    "example_robots",
    "gait",
    "gait_from_dict",
    "height_grid",
    "kkt_build",
    "kkt_solve",
    "matching_yaw_amplitude",
    "measured_period",
    "modes",
    "net_yaw",
    "one_leg_gait",
    "optimal_cycle",
    "optimise",
    "out_of_phase_gait",
    "pareto_front",
    "path_controllability",
    "pitch_response",
    "plan_yaw",
    "projected_acceleration",
    "record",
    "reduced_urdf",
    "reducibility",
    "reproduce",
    "rolling_null_space",
    "rolling_pendulum_period",
    "rolling_projector",
    "rotation_connection",
    "rrrobot_urdf",
    "simple_pendulum_period",
    "simulate",
    "sphere_contact_rate",
    "static_pitch",
    "sweep",
    "table_3",
    "table_4",
    "urdf_path",
    "weightless",
    "yaw_drift",
    "yaw_mass_matrix",
    "zero_set",
]

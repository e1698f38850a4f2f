"""rrrobot: legless locomotion of round robots. See README.md."""

from rrrobot import paper
from rrrobot.constraints import (
    Constraint,
    Instant,
    PrescribedJoints,
    RollingContact,
    contact_drift,
    contact_jacobian,
    contact_point,
)
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.kinematics import contact_path, contact_velocity, sphere_contact_rate
from rrrobot.contact.surfaces import Ellipsoid, Sphere, Surface
from rrrobot.drive.controllers import PID, Delayed, RandomTorques, SumOfLaws
from rrrobot.drive.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.drive.gaits import (
    CallableGait,
    FourierGait,
    Gait,
    LegMotion,
    RampIn,
    SinusoidalGait,
    StillLegs,
    gait,
)
from rrrobot.drive.laws import Clock, Memory, MotionState, TorqueLaw
from rrrobot.drive.moves import LegMoves, one_leg_gait, out_of_phase_gait
from rrrobot.drive.torques import LegTorques
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
    SlowWarning,
    SweepInterrupted,
    UrdfError,
)
from rrrobot.kkt import (
    ConstraintRows,
    KKTSolution,
    KKTSystem,
    kkt_build,
    kkt_solve,
    projected_acceleration,
    rolling_null_space,
    rolling_projector,
)
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.recombined import DecoupledModels
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.orbits.linearise import Linearisation, linearise
from rrrobot.orbits.oscillations import (
    Mode,
    PeriodRow,
    equilibrium,
    measured_period,
    modes,
    table_3,
)
from rrrobot.paper.closed_forms import (
    composite_period,
    pitch_response,
    rolling_pendulum_period,
    simple_pendulum_period,
    static_pitch,
    yaw_mass_matrix,
)
from rrrobot.paper.run import reproduce
from rrrobot.paper.table4 import Table4, table_4
from rrrobot.reduction.checks import (
    Controllability,
    Reducibility,
    controllability,
    path_controllability,
    reducibility,
)
from rrrobot.reduction.connection import Connection, rotation_connection
from rrrobot.reduction.cycles import OptimalCycle, optimal_cycle
from rrrobot.reduction.heights import height_grid, zero_set
from rrrobot.reduction.yaw import net_yaw
from rrrobot.robot.examples import example_robots
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.robot.urdf import reduced_urdf, rrrobot_urdf, urdf_path
from rrrobot.serial import register
from rrrobot.simulation.events import Event, Hit, Snapshot, lift_off, vertical
from rrrobot.simulation.fast import MomentumFlow
from rrrobot.simulation.flow import Evolution, Flow
from rrrobot.simulation.recombined import decoupled
from rrrobot.simulation.run import simulate
from rrrobot.simulation.state import State
from rrrobot.simulation.steady import SteadyState
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.steering.yaw_planner import YawPlan, plan_yaw
from rrrobot.studies.comparison import (
    Comparison,
    compare,
    matching_yaw_amplitude,
    yaw_drift,
)
from rrrobot.studies.optimisation.goals import (
    FastestTravel,
    LeastEffort,
    TargetMotion,
    TightestTurn,
)
from rrrobot.studies.optimisation.pareto import ParetoFront, pareto_front
from rrrobot.studies.optimisation.result import OptimisedGait, gait_from_dict
from rrrobot.studies.optimisation.run import optimise
from rrrobot.studies.optimisation.table import GaitLimits
from rrrobot.studies.sweeps.run import sweep
from rrrobot.view.viewer import Viewer, record

__all__ = [
    "PID",
    "BodyRateDamping",
    "CallableGait",
    "Clock",
    "Comparison",
    "Connection",
    "Constraint",
    "ConstraintError",
    "ConstraintRows",
    "Controllability",
    "Damping",
    "DecoupledModels",
    "Delayed",
    "Ellipsoid",
    "EulerRateDamping",
    "Event",
    "Evolution",
    "FastestTravel",
    "Flow",
    "FourierGait",
    "FullModel",
    "Gait",
    "GaitError",
    "GaitLimits",
    "Ground",
    "GroundClearanceWarning",
    "Hit",
    "Instant",
    "KKTSolution",
    "KKTSystem",
    "LeastEffort",
    "LegMotion",
    "LegMoves",
    "LegTorques",
    "Linearisation",
    "Memory",
    "MissingExtraError",
    "Mode",
    "ModelError",
    "MomentumFlow",
    "MotionState",
    "OptimalCycle",
    "OptimisedGait",
    "OutputError",
    "ParameterError",
    "ParetoFront",
    "PeriodRow",
    "PitchModel",
    "PivotingModel",
    "Plane",
    "PrescribedJoints",
    "RRRobotError",
    "RRRobotParameters",
    "RampIn",
    "RandomTorques",
    "Reducibility",
    "Robot",
    "RollModel",
    "RollingContact",
    "ShellError",
    "SimulationError",
    "SimulationInterrupted",
    "SinusoidalGait",
    "SlowWarning",
    "Snapshot",
    "Sphere",
    "State",
    "SteadyState",
    "StillLegs",
    "SumOfLaws",
    "Surface",
    "SweepInterrupted",
    "Table4",
    "TargetMotion",
    "TightestTurn",
    "TorqueLaw",
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
    "lift_off",
    "linearise",
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
    "register",
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
    "vertical",
    "yaw_drift",
    "yaw_mass_matrix",
    "zero_set",
]

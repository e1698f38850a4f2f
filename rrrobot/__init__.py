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
from rrrobot.oscillations import (
    Mode,
    PeriodRow,
    equilibrium,
    measured_period,
    modes,
    table_3,
)
from rrrobot.parameters import RRRobotParameters
from rrrobot.robot import Robot
from rrrobot.rolling import contact_path, contact_velocity, sphere_contact_rate
from rrrobot.simulate import simulate
from rrrobot.steady_state import SteadyState
from rrrobot.surfaces import Ellipsoid, Sphere, Surface
from rrrobot.table4 import Table4, table_4
from rrrobot.torques import LegTorques, MotionState
from rrrobot.trajectory import Trajectory
from rrrobot.urdf import reduced_urdf, rrrobot_urdf, urdf_path
from rrrobot.viewer import Viewer, record

__all__ = [
    "BodyRateDamping",
    "CallableGait",
    "Comparison",
    "ConstraintError",
    "ConstraintRows",
    "Damping",
    "Ellipsoid",
    "EulerRateDamping",
    "FourierGait",
    "FullModel",
    "Gait",
    "GaitError",
    "GroundClearanceWarning",
    "KKTSolution",
    "KKTSystem",
    "LegMotion",
    "LegTorques",
    "MissingExtraError",
    "Mode",
    "ModelError",
    "MotionState",
    "OutputError",
    "ParameterError",
    "PeriodRow",
    "PitchModel",
    "PivotingModel",
    "PrescribedJoints",
    "RRRobotError",
    "RRRobotParameters",
    "RampIn",
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
    "Table4",
    "Trajectory",
    "UrdfError",
    "Viewer",
    "YawModel",
    "compare",
    "composite_period",
    "contact_drift",
    "contact_jacobian",
    "contact_path",
    "contact_point",
    "contact_velocity",
    "decoupled",
    "equilibrium",
    "example_robots",
    "gait",
    "kkt_build",
    "kkt_solve",
    "matching_yaw_amplitude",
    "measured_period",
    "modes",
    "pitch_response",
    "projected_acceleration",
    "record",
    "reduced_urdf",
    "rolling_null_space",
    "rolling_pendulum_period",
    "rolling_projector",
    "rrrobot_urdf",
    "simple_pendulum_period",
    "simulate",
    "sphere_contact_rate",
    "static_pitch",
    "table_3",
    "table_4",
    "urdf_path",
    "yaw_drift",
    "yaw_mass_matrix",
]

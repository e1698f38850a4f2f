from rrrobot.robot.examples import example_robots as example_robots
from rrrobot.robot.legged import legged_urdf as legged_urdf
from rrrobot.robot.parameters import RRRobotParameters as RRRobotParameters
from rrrobot.robot.robot import Robot as Robot
from rrrobot.robot.urdf import reduced_urdf as reduced_urdf
from rrrobot.robot.urdf import rrrobot_urdf as rrrobot_urdf
from rrrobot.robot.urdf import urdf_path as urdf_path
from rrrobot.robot.variation import varied as varied

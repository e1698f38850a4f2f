"""From a wanted motion to leg motions: plans, obstacles, the yaw planner."""

from rrrobot.steering.obstacles import Disc, Polygon
from rrrobot.steering.planner import Plan, plan
from rrrobot.steering.yaw_planner import YawPlan, plan_yaw

__all__ = ["Disc", "Plan", "Polygon", "YawPlan", "plan", "plan_yaw"]

from rrrobot.steering.yaw_planner import YawPlan as YawPlan
from rrrobot.steering.yaw_planner import plan_yaw as plan_yaw

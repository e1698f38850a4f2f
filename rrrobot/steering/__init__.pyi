from rrrobot.steering.obstacles import Disc as Disc
from rrrobot.steering.obstacles import Polygon as Polygon
from rrrobot.steering.planned import Plan as Plan
from rrrobot.steering.planner import plan as plan
from rrrobot.steering.yaw_planner import YawPlan as YawPlan
from rrrobot.steering.yaw_planner import plan_yaw as plan_yaw

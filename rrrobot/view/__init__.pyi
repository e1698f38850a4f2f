from rrrobot.view.inline import show as show
from rrrobot.view.viewer import Viewer as Viewer
from rrrobot.view.viewer import record as record

from rrrobot.view.films import record as record
from rrrobot.view.inline import show as show
from rrrobot.view.viewer import Viewer as Viewer

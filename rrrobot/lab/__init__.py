"""The laboratory: a gait under the hands of whoever sits at the browser.

Read in this order: `knobs` is what can be set, `outcome` what comes of it, `motion` what can be
played, `stage` draws the scene's commands with viser, `drawing` a motion, `panel` holds sliders and
numbers, `session` joins them for one client, `server` opens the page.
"""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)

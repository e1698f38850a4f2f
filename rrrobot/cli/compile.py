"""Says so when the momentum engine is about to be compiled, which happens once."""

from __future__ import annotations

import click


def tell_of_compiling(*, quiet: bool, loads: bool = False, alone: bool = False) -> None:
    """One line on stderr if the next use of the engine compiles it.

    Args:
        quiet: say nothing.
        loads, alone: as for `momentum.batch.ready`.
    """
    if quiet:
        return
    # Numba loads here, so that it costs nobody who does not use it.
    from rrrobot.momentum.batch import ready

    if not ready(loads=loads, alone=alone):
        click.echo("compiling the momentum engine: about 15 s, once after installation", err=True)

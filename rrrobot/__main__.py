"""`python -m rrrobot` is the command `rrrobot`."""

from rrrobot.cli.main import main

main()

"""`python -m rrrobot` is the command `rrrobot`."""

from rrrobot.cli import main

main()

"""The command line: one file for each command, whose imports wait until it runs."""

from kousoku.cli.app import main

__all__ = ["main"]

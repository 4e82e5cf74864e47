"""The command line: arguments in, words out."""

from staffa.cli.commands import main

__all__ = ["main"]

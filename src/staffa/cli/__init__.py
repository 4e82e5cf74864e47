"""Command line of staffa."""

from staffa.cli.commands import main

__all__ = ["main"]

"""The command line. Whatever is slow to import is imported by the command that needs it."""

from crispline.cli import clouds, experiments, surfaces
from crispline.cli.program import program as main

__all__ = ["clouds", "experiments", "main", "surfaces"]

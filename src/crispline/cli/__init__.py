"""The command line. Whatever is slow to import is imported by the command that needs it."""

from crispline.cli import clouds, compare, convert, experiments, inspect, surfaces, view
from crispline.cli.program import program as main

__all__ = ["clouds", "compare", "convert", "experiments", "inspect", "main", "surfaces", "view"]

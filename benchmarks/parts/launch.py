"""Run a command and write the most memory it held, in MB, to a file.

A process starts with the peak of the one that made it (Linux), so a lean one stands between
the driver and the program.
"""

import resource
import subprocess
import sys

_UNIT = 2**20 if sys.platform == "darwin" else 2**10  # bytes there, kilobytes elsewhere


def main() -> None:
    """``launch.py FILE COMMAND...``; ends as the command does."""
    exit_code = subprocess.call(sys.argv[2:])
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / _UNIT
    with open(sys.argv[1], "w", encoding="ascii") as file:
        file.write(f"{exit_code} {peak}")


if __name__ == "__main__":
    main()

"""``python -m crispline`` is the command line."""

from crispline.cli import main

if __name__ == "__main__":
    main(prog_name="crispline")

"""Run the command line with ``python -m sstl_cli``."""

from sstl_cli.cli.app import program

if __name__ == "__main__":
    program()

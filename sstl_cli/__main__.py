"""Run the command line with ``python -m sstl_cli``."""

from sstl_cli.cli.app import main

if __name__ == "__main__":
    main()

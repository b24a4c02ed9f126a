"""Run the command line: ``python -m slipfold.interface.cli``."""

from slipfold.interface.cli import main

if __name__ == "__main__":
    main()

"""Run the command line: ``python -m slipfold.cli``."""

from slipfold.cli import main

if __name__ == "__main__":
    main()

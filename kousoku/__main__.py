"""Run the command line as ``python -m kousoku``."""

from kousoku.cli import main

if __name__ == "__main__":
    main()

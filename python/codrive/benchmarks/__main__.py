"""``python -m codrive.benchmarks``: the table of results of the benchmarks."""

import sys

from codrive.benchmarks._table import main

if __name__ == "__main__":
    sys.exit(main())

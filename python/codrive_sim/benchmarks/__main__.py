"""``python -m codrive_sim.benchmarks``: the table of results of the benchmarks, and trainings of their policies."""

import sys

from codrive_sim.benchmarks._command import main

if __name__ == "__main__":
    sys.exit(main())

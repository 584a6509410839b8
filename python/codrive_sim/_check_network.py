"""Checks a network that does not come with codrive in a separate process: if SUMO crashes on it, only that process ends.

The process runs this file directly, so that it loads the native part and nothing else.
"""

import os
import sys

if __name__ == "__main__":
    # Python does not search this file's folder if PYTHONSAFEPATH is set.
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    import _codrive

    try:
        _codrive.try_network(sys.argv[1])
    except RuntimeError as why:
        sys.exit(str(why))

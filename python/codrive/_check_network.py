"""Tries a network that does not come with codrive in a process of its own: SUMO takes a process along where it breaks down on one.

It is run as a file, so that it loads the native part and nothing else.
"""

import os
import sys

if __name__ == "__main__":
    # Its folder is not where Python looks if PYTHONSAFEPATH is set.
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    import _codrive

    try:
        _codrive.try_network(sys.argv[1])
    except RuntimeError as why:
        sys.exit(str(why))

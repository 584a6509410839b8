"""Checks the HED tags of a BIDS data set with hedtools, off-line. In: the data set's folder. Out: one line a fault; nothing for none.

Shortest first: the sidecar alone, then each table of events with it, rows assembled.
"""

import json
import socket
import sys
from pathlib import Path


def refuse(*_):
    raise OSError("the words of HED come with hedtools; nothing is to be fetched")


socket.socket.connect = refuse

from hed import Sidecar, TabularInput, get_printable_issue_string  # noqa: E402
from hed.schema import load_schema_version  # noqa: E402

root = Path(sys.argv[1])
version = json.loads((root / "dataset_description.json").read_text())["HEDVersion"]
schema = load_schema_version(version)
sidecar = Sidecar(str(root / "events.json"))
faults = sidecar.validate(schema)
for path in sorted(root.glob("sub-*/*/*_events.tsv")):
    faults += TabularInput(str(path), sidecar=sidecar).validate(schema)
if faults:
    print(get_printable_issue_string(faults))

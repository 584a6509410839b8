"""Reads every text file below a folder as its own format does, and fails where a free text of a study became markup, a cell or a line.
Prints how many files of each kind were read, and how many of them hold such a text."""

import collections
import csv
import html.parser
import json
import pathlib
import re
import sys
import tomllib
import xml.etree.ElementTree

read, held = collections.Counter(), collections.Counter()


def check(condition, path, what):
    if not condition:
        sys.exit(f"{path}: {what}")


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.path, self.words = path, []

    def handle_starttag(self, tag, attributes):
        check(tag != "hostile", self.path, f"a text became a tag: {self.getpos()}")
        check(all("hostile" not in name for name, _ in attributes), self.path, f"a text became an attribute: {attributes}")

    def handle_data(self, data):
        self.words.append(data)


def plain(text, path):
    bad = re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]", text)
    check(not bad, path, f"a control character: {bad and repr(text[max(bad.start() - 40, 0):bad.end() + 40])}")


def of_kind(kind, text, path):
    if kind == "json":
        json.loads(text)
    elif kind == "tsv":
        plain(text, path)
        cells = {len(line.split("\t")) for line in text.removesuffix("\n").split("\n")}
        check(len(cells) == 1, path, f"rows of {cells} cells")
        check(text.splitlines() == text.removesuffix("\n").split("\n"), path, "a cell parts a line")
    elif kind == "csv":
        cells = {len(row) for row in csv.reader(text.splitlines(keepends=True), strict=True)}
        check(len(cells) == 1, path, f"rows of {cells} cells")
    elif kind == "html":
        page = Page(path)
        page.feed(text)
        page.close()
        check("<hostile onhostile=" in "".join(page.words), path, "the title is not shown as it is")
    elif kind == "svg":
        tree = xml.etree.ElementTree.fromstring(text)
        check(all("hostile" not in element.tag for element in tree.iter()), path, "a text became an element")
    elif kind == "md":
        plain(text, path)
        check(not re.search(r"(?<!\\)(<hostile|\[hostile|\*hostile|`hostile)", text), path, "a text became markup")
    elif kind == "toml":
        tomllib.loads(text)
    elif kind == "txt":
        plain(text, path)


for path in sorted(pathlib.Path(sys.argv[1]).rglob("*")):
    kind = path.suffix[1:]
    if path.is_file() and kind in ("json", "tsv", "csv", "html", "svg", "md", "toml", "txt"):
        text = path.read_bytes().decode()
        of_kind(kind, text, path)
        read[kind] += 1
        held[kind] += "hostile" in text
print(" ".join(f"{kind}:{count}:{held[kind]}" for kind, count in sorted(read.items())))

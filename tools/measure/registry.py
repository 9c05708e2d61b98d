"""Tables by name, their Markdown, and the sections of pages that they fill."""
import difflib
import fnmatch
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Callable


class MeasureError(Exception):
    """What the user can mend: told in one line."""


@dataclass
class Table:
    name: str
    about: str
    takes: str  # how long, in words
    page: str  # "" where it only writes files
    files: str  # what else it writes, in words
    keeps_rows: bool  # rows that are not measured this time stay: part of it may be measured
    make: Callable  # of a Measurement: the section's text


tables: dict[str, Table] = {}


def table(name, about, takes, page="", files="", keeps_rows=False):
    """Decorator of a function that measures `name` and returns the section of `page` (None: it has only written `files`)."""

    def register(make):
        tables[name] = Table(name, about, takes, page, files, keeps_rows, make)
        return make

    return register


def find(pattern):
    """Tables of that name or pattern ("coil*")."""
    found = [tables[name] for name in tables if fnmatch.fnmatchcase(name, pattern)]
    if found:
        return found
    near = difflib.get_close_matches(pattern, tables, 1, 0.4)
    raise MeasureError(f'no table "{pattern}"' + (f'; did you mean "{near[0]}"?' if near else "") + " (--list shows all)")


def markdown(columns, rows):
    """A table; cells are texts."""
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(str(cell).replace("|", "/").replace("\n", " ") for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def replace_section(page, name, section):
    """The text of the page with `section` between its markers <!-- begin NAME --> and <!-- end NAME -->, indented as the first one is."""
    lines = page.splitlines(keepends=True)
    places = []
    for marker in (f"<!-- begin {name} -->", f"<!-- end {name} -->"):
        found = [k for k, line in enumerate(lines) if line.strip() == marker]
        if len(found) != 1:
            raise MeasureError(f"the page has {len(found)} lines {marker}; it needs one")
        places += found
    begin, end = places
    if end < begin:
        raise MeasureError(f"section {name} ends before it begins")
    indent = lines[begin][: len(lines[begin]) - len(lines[begin].lstrip())]
    new = "".join((indent + line).rstrip() + "\n" for line in section.strip("\n").split("\n"))
    return "".join(lines[: begin + 1]) + new + "".join(lines[end:])


def page_with(path: Path, name, section):
    """The page as it is now, with that section. @throws MeasureError where it cannot take it"""
    if not path.is_file():
        raise MeasureError(f"there is no page {path}")
    with open(path, newline="", encoding="utf-8") as page:
        text = page.read()
    try:
        return replace_section(text, name, section)
    except MeasureError as error:
        raise MeasureError(f"{path}: {error}") from None


def write_file(path: Path, content: bytes):
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(path.name + ".new")
    beside.write_bytes(content)
    os.replace(beside, path)

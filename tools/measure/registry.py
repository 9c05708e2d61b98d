"""Tables by name, their Markdown, and the sections of pages that they fill."""
import difflib
import fnmatch
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Callable


class MeasureError(Exception):
    """A mistake that the user can fix, reported in one line."""


@dataclass
class Table:
    name: str
    about: str
    takes: str  # duration, as text
    make: Callable  # make(Measurement) returns the section's text, or None
    files: str = ""  # other files that it writes, as text
    section: bool = True
    keeps_rows: bool = False  # whether rows that are not measured keep their values, so that --only may write to the page


tables: dict[str, Table] = {}


def table(name, about, takes, **keys):
    """Decorator: registers a function that measures `name` and returns its section."""

    def register(make):
        tables[name] = Table(name, about, takes, make, **keys)
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
    """A Markdown table. In cells, a line break becomes a blank and | becomes /. @param columns "a | b | c"
    @param rows lists of cells; short rows are padded with empty cells"""
    names = columns.split(" | ")
    lines = [names, ["---"] * len(names)]
    lines += [[str(cell).replace("|", "/").replace("\n", " ") for cell in row] + [""] * (len(names) - len(row)) for row in rows]
    return "\n".join("|" + "".join(f" {cell} |" if cell else " |" for cell in line) for line in lines).replace(" --- ", "---")


def percent(part, digits=0):
    return f"{100 * part:.{digits}f} %"


def off(value, expected, digits=0):
    """Relative difference of a value from the expected one, in %."""
    return f"{100 * (value / expected - 1):+.{digits}f} %"


# Sections of pages

def markers(name):
    return f"<!-- begin {name} -->", f"<!-- end {name} -->"


def page_with(top: Path, name):
    """The page that contains the section: README.md or one in docs."""
    pages = [page for page in (top / "README.md", *sorted(top.glob("docs/**/*.md"))) if page.is_file()]
    found = [page for page in pages if any(line.strip() == markers(name)[0] for line in page.read_text(encoding="utf-8").splitlines())]
    if len(found) != 1:
        raise MeasureError(f"{len(found) or 'no'} pages contain the line {markers(name)[0]}; exactly one must")
    return found[0]


def replace_section(page, name, section):
    """The text of the page with `section` between its markers, indented like the first marker."""
    lines = page.splitlines(keepends=True)
    places = []
    for marker in markers(name):
        found = [k for k, line in enumerate(lines) if line.strip() == marker]
        if len(found) != 1:
            raise MeasureError(f"the page has {len(found)} lines {marker}; it needs exactly one")
        places += found
    begin, end = places
    if end < begin:
        raise MeasureError(f"section {name} ends before it begins")
    indent = lines[begin][: len(lines[begin]) - len(lines[begin].lstrip())]
    new = "".join((indent + line).rstrip() + "\n" for line in section.strip("\n").split("\n"))
    return "".join(lines[: begin + 1]) + new + "".join(lines[end:])


def read_page(path: Path):
    with open(path, newline="", encoding="utf-8") as page:
        return page.read()


def write_file(path: Path, content: bytes):
    """Writes atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(path.name + ".new")
    fresh.write_bytes(content)
    os.replace(fresh, path)

"""The command line of tools/measure.py."""
import argparse
import sys
import traceback

from . import registry, runs
from . import coils, departures, laboratory_water, laboratory_honey, live, micropolar, notes, pictures, pressure, references  # noqa: F401
from . import sheet, steps, surfaces, tradeoff, viscosity, vortices  # noqa: F401  (each registers tables)

examples = """examples:
  tools/measure.py --list                           every name, what it is and how long it takes
  tools/measure.py sewing_machine                   measures it and writes it into its page
  tools/measure.py coils --only 2 --only 7          two of its rows, printed; results stay in out/measure
  tools/measure.py coils --only 2 --set fluid.spacing=2.5e-3
  tools/measure.py 'map_*' --dry-run                what would be run
  tools/measure.py auto --print --program ../other/build/release/whorl"""


def parser():
    p = argparse.ArgumentParser(prog="tools/measure.py", epilog=examples, formatter_class=argparse.RawDescriptionHelpFormatter,
                                description="Measures the tables and images of README.md and docs again, by name. A table goes "
                                "between the lines <!-- begin NAME --> and <!-- end NAME --> of the page that has them; nothing else of a "
                                "page changes.")
    p.add_argument("names", nargs="*", metavar="NAME", help="a table or picture, or a pattern of names")
    p.add_argument("--list", action="store_true", help="show all names")
    p.add_argument("--print", action="store_true", help="print the section, write nothing into the pages")
    p.add_argument("--dry-run", action="store_true", help="print the commands, run nothing")
    p.add_argument("--again", action="store_true", help="repeat the measurements that out/measure already contains")
    p.add_argument("--only", action="append", default=[], metavar="ROW", help="these scenes or rows alone (repeatable)")
    p.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                   help="of every run, for a try that is printed and not written (repeatable)")
    p.add_argument("--program", help="the whorl to measure (default: $WHORL, or build/release/whorl, built when it is missing)")
    p.add_argument("--into", default=runs.root, metavar="FOLDER", help="another copy of README.md and docs to write into")
    return p


def show_list():
    width = max(len(name) for name in registry.tables)
    for t in registry.tables.values():
        print(f"{t.name:{width}}  {t.about} [{t.takes}]" + f" -> {t.files}" * bool(t.files))


def measure(table, m):
    to_page = table.section and m.writes and (table.keeps_rows or not m.only)
    if to_page:  # errors of the page are reported before hours are spent
        page = registry.page_with(m.into, table.name)
        registry.replace_section(registry.read_page(page), table.name, "")
    m.say(f"{table.name} ({table.takes})")
    section = table.make(m)
    if m.dry or section is None:
        return
    if to_page:
        text = registry.read_page(page)  # it may have changed meanwhile
        registry.write_file(page, registry.replace_section(text, table.name, section).encode())
        m.say(f"{table.name}: written to {page.relative_to(m.into)}")
    else:
        print(section)


def main(arguments):
    p = parser()
    options = p.parse_args(arguments)
    if options.list:
        show_list()
        return 0
    if not options.names:
        p.print_usage(sys.stderr)
        return 2
    try:
        chosen = [table for name in options.names for table in registry.find(name)]
    except registry.MeasureError as error:
        print(f"measure.py: {error}", file=sys.stderr)
        return 2
    m = runs.Measurement(options.program, options.again, options.dry_run, options.only, options.set, options.into, not options.print)
    failed = 0
    for table in chosen:
        try:
            measure(table, m)
        except registry.MeasureError as error:
            print(f"measure.py: {table.name}: {error}", file=sys.stderr)
            failed = 1
        except Exception:  # the others may still be measured
            print(f"measure.py: {table.name}: {traceback.format_exc()}", file=sys.stderr)
            failed = 1
        except KeyboardInterrupt:
            print(f"measure.py: {table.name}: interrupted; what is done is kept", file=sys.stderr)
            return 130
    return failed

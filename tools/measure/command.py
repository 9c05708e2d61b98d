"""The command line of tools/measure.py."""
import argparse
import sys
import traceback

from . import registry, runs
from . import coils, departures, growth, laboratory_water, laboratory_honey, live, micropolar, notes, peer, pictures, pressure, references  # noqa: F401
from . import sheet, steps, surfaces, tradeoff, viscosity, vortices  # noqa: F401  (each registers tables)

examples = """examples:
  tools/measure.py --list                           lists every name with its content and duration
  tools/measure.py sewing_machine                   measures it and writes it into its page
  tools/measure.py coils --only 2 --only 7          measures two rows and prints them; results stay in out/measure
  tools/measure.py coils --only 2 --set fluid.spacing=2.5e-3
  tools/measure.py 'map_*' --dry-run                prints the commands
  tools/measure.py auto --print --program ../other/build/release/whorl"""


def parser():
    p = argparse.ArgumentParser(prog="tools/measure.py", epilog=examples, formatter_class=argparse.RawDescriptionHelpFormatter,
                                description="Measures the tables and images of README.md and docs again, by name. A table is "
                                "written between the lines <!-- begin NAME --> and <!-- end NAME --> of its page; the rest of the page "
                                "stays unchanged.")
    p.add_argument("names", nargs="*", metavar="NAME", help="a table or image, or a pattern of names")
    p.add_argument("--list", action="store_true", help="show all names")
    p.add_argument("--print", action="store_true", help="print the section instead of writing it into its page")
    p.add_argument("--dry-run", action="store_true", help="print the commands, run nothing")
    p.add_argument("--again", action="store_true", help="repeat the measurements that out/measure already contains")
    p.add_argument("--only", action="append", default=[], metavar="ROW", help="measure only this scene or row (repeatable)")
    p.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                   help="set a key in every run; the result is printed, not written into its page (repeatable)")
    p.add_argument("--program", help="program to measure (default: $WHORL, else build/release/whorl, which is built if it is missing)")
    p.add_argument("--into", default=runs.root, metavar="FOLDER", help="folder with another copy of README.md and docs, to write into")
    return p


def show_list():
    width = max(len(name) for name in registry.tables)
    for t in registry.tables.values():
        print(f"{t.name:{width}}  {t.about} [{t.takes}]" + f" -> {t.files}" * bool(t.files))


def measure(table, m):
    to_page = table.section and m.writes and (table.keeps_rows or not m.only)
    if to_page:  # check the page before measuring for hours
        page = registry.page_with(m.into, table.name)
        registry.replace_section(registry.read_page(page), table.name, "")
    m.say(f"{table.name} ({table.takes})")
    section = table.make(m)
    if m.dry or section is None:
        return
    if to_page:
        text = registry.read_page(page)  # again, because it may have changed during the measurement
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
        except Exception:  # continue with the other tables
            print(f"measure.py: {table.name}: {traceback.format_exc()}", file=sys.stderr)
            failed = 1
        except KeyboardInterrupt:
            print(f"measure.py: {table.name}: interrupted; finished runs are kept", file=sys.stderr)
            return 130
    return failed

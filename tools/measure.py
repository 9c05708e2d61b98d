#!/usr/bin/python3
"""Measures the tables and images of README.md and docs again, by name: tools/measure.py --help."""
import sys

sys.dont_write_bytecode = True
try:
    from measure.command import main
except ModuleNotFoundError as missing:
    sys.exit(f"measure.py: {missing}; bash tools/setup.sh installs it for Debian's own Python")

sys.exit(main(sys.argv[1:]))

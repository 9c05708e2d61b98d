#!/usr/bin/python3
"""Measures again what README.md and docs say, by name: tools/measure.py --help."""
import sys

sys.dont_write_bytecode = True
from measure.command import main

sys.exit(main(sys.argv[1:]))

"""The tables and pictures of README.md and docs, one function each: tools/measure.py makes them by name.

command.py: the command line. registry.py: names, Markdown, sections of pages. runs.py: runs of whorl and what they wrote. drawing.py,
theory.py: pictures and numerics. references.py: flows by other methods. All others hold tables. solver/: a C++ program for what needs the
inside of a solver.
"""

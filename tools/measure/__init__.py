"""The tables and pictures of README.md and docs, one function each: tools/measure.py makes them by name.

command.py: the command line. registry.py: names, Markdown, sections of pages. runs.py: runs of whorl and what they wrote. drawing.py,
theory.py: plots and numerics. references.py: flows by other methods. All others contain tables. solver/: a C++ program for what needs the
inside of a solver.
"""

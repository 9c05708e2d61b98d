"""Tables and images of README.md and docs, one function each. tools/measure.py NAME makes one of them.

command.py: command line. registry.py: names, Markdown, sections of pages. runs.py: runs of whorl and readers of their files. drawing.py,
theory.py: plots and numerics. references.py, sheet.py: reference solutions by other methods. All other modules contain tables. solver/: a
C++ program for measurements that call a solver directly.
"""

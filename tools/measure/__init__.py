"""The tables and pictures of README.md and docs: one function each. tools/measure.py runs them by name.

command.py      the command line              registry.py   names, Markdown, sections of pages
runs.py         runs of whorl and results     drawing.py    pictures              theory.py   numerics
pictures.py     README and guide              coils.py, viscosity.py, pressure.py, micropolar.py, tradeoff.py   docs/reports
"""

"""Puts the tables of `gmis-compare`'s report.md about the paper's scenes into a document:
put_paper_table.py REPORT DOCUMENT."""

import pathlib
import sys

from measuring import write_into


def first_tables(report):
    """For every section its heading, its first table and the line about its reference."""
    kept = []
    for section in report.split("### ")[1:]:
        name, *lines = section.splitlines()
        rows = lines[lines.index(next(line for line in lines if line.startswith("|"))):]
        table = rows[: next((i for i, line in enumerate(rows) if not line.startswith("|")), len(rows))]
        reference = [line for line in lines if line.startswith("Reference:")]
        kept += [f"**{name}**", "", *table, "", *reference, ""]
    settings = report.strip().splitlines()[-1]
    return "\n".join([*kept, settings, ""])


report, document = map(pathlib.Path, sys.argv[1:])
write_into(document, "convergence", first_tables(report.read_text()))

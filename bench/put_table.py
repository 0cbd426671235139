"""Puts a table between its marks in a document: put_table.py DOCUMENT NAME COMMAND FILE."""

import pathlib
import sys

from measuring import write_into

document, name, command, file = sys.argv[1:]
write_into(pathlib.Path(document), f"<!-- {name}: written by {command} -->", f"<!-- end of {name} -->", pathlib.Path(file).read_text())

"""A document shows what a program prints. Usage: printed.py DOCUMENT PROGRAM

The lines on standard error, or those on standard output where there are none, must stand together
in the document. Numbers are printed with few digits, so that every machine prints the same."""

import pathlib
import subprocess
import sys

document, program = sys.argv[1:]
said = subprocess.run([program], check=True, capture_output=True, text=True)
printed = said.stderr or said.stdout
if not printed.strip():
    raise SystemExit(f"{program} prints nothing")
if f"```text\n{printed}```\n" not in pathlib.Path(document).read_text(encoding="utf-8"):
    raise SystemExit(f"{document} does not say what {program} prints:\n{printed}")

"""Methods of multiple importance sampling beside N3, at equal evaluations of f, on four integrals
(examples/which_method.cpp).

Writes the table in docs/mis-methods.md.
"""

import subprocess

from measuring import build, publish

DOCUMENT = "docs/mis-methods.md"


def run(options):
    said = subprocess.run([build("which_method", "examples")], check=True, capture_output=True, text=True).stdout
    print(said, end="")
    lines = said.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("|"))
    publish(options, "\n".join(lines[first:lines.index("", first)]) + "\n", DOCUMENT)

"""The table of members in docs/your-renderer.md has the declarations that a compiler quotes
(core/missing_members.hpp) but for names of arguments, all of those that are required, and no
other.

Usage: declarations.py PROJECT_DIR
"""

import pathlib
import re
import sys

project = pathlib.Path(sys.argv[1])
page = (project / "docs/your-renderer.md").read_text(encoding="utf-8")
header = (project / "include/gmis/core/missing_members.hpp").read_text(encoding="utf-8")


def types_of(declaration):
    return re.sub(r" [a-z_]+(?=[,)])", "", declaration)


table = page[page.index("| of | member | gives |") :].split("\n\n")[0]
shown = {types_of(re.sub(r"\bV\b", "Vec3<T>", row.split("`")[1])) + " const" for row in table.splitlines()[2:]}

wanted = set()
for concept in ("bsdf", "light", "camera", "scene"):
    part = header[header.index(f"namespace {concept}_lacks") :].split("\n}")[0]
    wanted |= {types_of(line.split("// ", 1)[1]) for line in part.splitlines() if re.search(r"// .*\) const$", line)}
lobes = {line for line in wanted if re.search(r"\b(lobe\w*|sample_lobe|has_delta_lobes|lobes\w*)\(", line)}  # optional

faults = [f"not quoted by the compiler: {line}" for line in sorted(shown - wanted)]
faults += [f"not in the table: {line}" for line in sorted(wanted - lobes - shown)]
print(*faults, f"{len(shown)} members, {len(faults)} faults", sep="\n")
sys.exit(1 if faults else 0)

"""Every name in the code spans of the given pages must occur in the project's code.

Usage: names_exist.py PROJECT_DIR FILE.md...
"""
import pathlib
import re
import sys

project = pathlib.Path(sys.argv[1])
sources = [path for folder in ("include", "examples", "tests", "bench") for path in (project / folder).rglob("*")
           if "docs" not in path.parts and path.suffix in (".hpp", ".cpp", ".py", ".cmake", ".txt")]
known = set()
for path in sources:
    known.update(re.findall(r"[A-Za-z_]\w*", path.read_text(encoding="utf-8")))
    known.update(path.relative_to(project).parts)
    known.add(path.stem)

# What is not the project's: the language, and letters that stand for something.
others = {"std", "f", "x", "i", "T", "static_assert", "MyMaterial", "MyBsdf"}
faults = 0
for page in sys.argv[2:]:
    text = re.sub(r"^```.*?^```", "", pathlib.Path(page).read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for line, content in enumerate(text.splitlines(), 1):
        for span in re.findall(r"`([^`]+)`", content):
            for name in re.findall(r"[A-Za-z_]\w*(?:\.hpp)?", span):
                if name.removesuffix(".hpp") not in known and name not in known and name not in others:
                    print(f"{page}: `{span}` names {name}, which is nowhere in the code")
                    faults += 1
print(f"{len(sys.argv) - 2} pages, {faults} faults")
sys.exit(1 if faults else 0)

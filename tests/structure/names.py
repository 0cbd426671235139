#!/usr/bin/env python3
"""The names of tests: every program in tests/PART is called test_PART_…, and every source belongs
to a program. With --fix, programs are renamed, wherever their names stand.
"""

import pathlib
import re
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[2]
# Parts whose tests are no programs of their own kind, or are called after what they try to break.
OTHERS = {"consumer", "docs", "fuzz", "headers", "linkage", "negative_compile", "packaging", "structure", "words"}
# Where names of tests stand.
MENTIONS = ["CMakePresets.json", ".ci/run", "run", "*.md", "docs/*.md", "tests/**/*", "bench/**/*.py", "examples/**/*.cmake"]


def parts():
    """For each part the text of its CMake files."""
    for folder in sorted((PROJECT / "tests").iterdir()):
        if folder.name not in OTHERS and (folder / "CMakeLists.txt").exists():
            files = [folder / "CMakeLists.txt", *sorted(folder.glob("*.cmake"))]
            yield folder, "\n".join(file.read_text(encoding="utf-8") for file in files)


def programs(text):
    return re.findall(r"gmis_add_(?:\w+_)?test\(\s*(test_\w+|\w+_test)\b", text)


def right_name(part, name):
    topic = re.sub(rf"^{part}_", "", re.sub(r"^test_|_test$", "", name))
    return f"test_{part}" if topic == part else f"test_{part}_{topic}"


def check():
    wrong, faults = {}, []
    for folder, text in parts():
        for name in programs(text):
            right = right_name(folder.name, name)
            if right != name:
                wrong[name] = right
                faults.append(f"tests/{folder.name}: {name} is not called {right}")
        for source in sorted(folder.glob("*.cpp")):
            if source.stem.endswith("_engines"):  # compiled once for all tests, by tests/CMakeLists.txt
                continue
            if not re.search(rf"\b{re.escape(source.name)}", text) and not re.search(rf"\b{source.stem}\b", text):
                faults.append(f"tests/{folder.name}: no program has {source.name}")
    return wrong, faults


def rename(wrong):
    pattern = re.compile(r"(?<![\w/])(" + "|".join(sorted(map(re.escape, wrong), key=len, reverse=True)) + r")(?!\w|/|\.(?:cpp|hpp|py)\b)")
    for mention in MENTIONS:
        for file in PROJECT.glob(mention):
            if not file.is_file() or "__pycache__" in file.parts:
                continue
            try:
                text = file.read_text(encoding="utf-8")
            except UnicodeDecodeError:
                continue
            changed = pattern.sub(lambda found: wrong[found[1]], text)
            if changed != text:
                file.write_text(changed, encoding="utf-8")
                print(file.relative_to(PROJECT))


def main():
    wrong, faults = check()
    if "--fix" in sys.argv[1:] and wrong:
        rename(wrong)
        wrong, faults = check()
    print("\n".join([*faults, f"{len(faults)} faults"]))
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())

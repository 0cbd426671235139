"""Every page of the documents is at most three clicks away from the README, and docs/index.md links
to every page of docs/.

Usage: reachable.py PROJECT_DIR
"""

import pathlib
import re
import sys

CLICKS = 3


def links_of(page):
    """The Markdown pages that a page links to."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    targets = re.findall(r"\]\(([^)\s#]+\.md)(?:#[^)]*)?\)", text)
    return {(page.parent / target).resolve() for target in targets if "://" not in target}


def main(project):
    start = project / "README.md"
    clicks, pages = {start: 0}, [start]
    for page in pages:
        for target in sorted(links_of(page)):
            if target not in clicks and target.exists():
                clicks[target] = clicks[page] + 1
                pages.append(target)
    faults = []
    docs = sorted((project / "docs").glob("*.md"))
    linked = links_of(project / "docs" / "index.md")
    for page in [*docs, *sorted(project.glob("*.md"))]:
        name = page.relative_to(project)
        if page.name.endswith(".next.md"):
            continue
        if clicks.get(page, CLICKS + 1) > CLICKS:
            faults.append(f"{name}: more than {CLICKS} clicks from README.md")
        if page.parent.name == "docs" and page.name != "index.md" and page not in linked:
            faults.append(f"{name}: docs/index.md does not link to it")
    for fault in faults:
        print(fault)
    print(f"{len(clicks)} pages, at most {max(clicks.values())} clicks; {len(faults)} faults")
    return 1 if faults else 0


sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))

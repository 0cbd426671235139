"""The README has at most 500 words beside code, tables, pictures and marks. Usage: readme_words.py
README.md"""

import pathlib
import re
import sys

LIMIT = 500


def words_of(text):
    """The words that a reader reads as sentences."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"<!--.*?-->|<sub>.*?</sub>|!\[[^\]]*\]\([^)]*\)", "", text, flags=re.DOTALL)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    lines = [line for line in text.split("\n") if not line.startswith("|")]
    return [word for word in "\n".join(lines).split() if re.search(r"\w", word)]


count = len(words_of(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")))
print(f"{count} words, at most {LIMIT}")
sys.exit(0 if count <= LIMIT else 1)

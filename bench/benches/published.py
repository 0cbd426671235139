"""Problems of the literature: published figures, or figures of other programs, beside those of the
library (bench/published.cpp)."""

import subprocess

PROGRAM = "published"


def run(options):
    return subprocess.run([options.program], check=False).returncode

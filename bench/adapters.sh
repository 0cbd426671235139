#!/usr/bin/env bash
# What each adapter of examples/ costs: its lines and those of a complete program, processor time and memory to compile that
# program at -O2, and the library's share of the instructions of an iteration. bench/adapters.py says how.
#
# Usage: bench/adapters.sh [lines|compile|share]...   (default: all three)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec python3 bench/adapters.py "$@"

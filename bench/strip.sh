#!/usr/bin/env bash
# The README's strip of pictures at equal time. bench/strip.py says how and takes the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render first_render >/dev/null
python3 bench/strip.py build/bench/examples/gmis-render --first-render build/bench/examples/first_render "$@"

#!/usr/bin/env bash
# What a pilot costs, over 8, 16 and 64 iterations of eighteen scenes. bench/pilot.py says how and takes the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/pilot.py --renderer build/bench/examples/gmis-render "$@"

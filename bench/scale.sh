#!/usr/bin/env bash
# How time grows with light vertices, lights and depth, and falls with threads. bench/scale.py says how and takes the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/scale.py --renderer build/bench/examples/gmis-render "$@"

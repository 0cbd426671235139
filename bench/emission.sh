#!/usr/bin/env bash
# What learned emission gives: relMSE times processor seconds by power over the same learned, where lights shine far beyond the picture,
# and where they do not. bench/emission.py says how and takes the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/emission.py --renderer build/bench/examples/gmis-render "$@"

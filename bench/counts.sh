#!/usr/bin/env bash
# What learned numbers of samples at camera vertices give: relMSE times processor seconds with uniform counts over the same learned.
# bench/counts.py says how and takes the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/counts.py --renderer build/bench/examples/gmis-render "$@"

#!/usr/bin/env bash
# Low-discrepancy numbers beside independent ones: squared error and processor time over fourteen scenes. bench/samplers.py says how and takes
# the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/samplers.py --renderer build/bench/examples/gmis-render "$@"

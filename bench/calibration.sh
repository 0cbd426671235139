#!/usr/bin/env bash
# Whether the error that a run states is its true one, and whether its interval covers that, on fifteen scenes, half of them
# with fireflies. bench/calibration.py says how and takes the options; it writes the table in docs/accuracy-and-time.md.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/calibration.py --renderer build/bench/examples/gmis-render "$@"

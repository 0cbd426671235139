#!/usr/bin/env bash
# Whether --integrator auto finds what pays: its error × time beside that of every fixed integrator with its options tried
# out, on fourteen scenes. bench/effects.py says how and takes the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/effects.py --renderer build/bench/examples/gmis-render "$@"

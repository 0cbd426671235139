#!/usr/bin/env bash
# Whether --integrator auto loses or adds light, on fourteen scenes and on ten that tempt it to. bench/energy.py says how and takes
# the options; it writes the table in docs/effects.md.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/energy.py --renderer build/bench/examples/gmis-render "$@"

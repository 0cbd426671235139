#!/usr/bin/env bash
# What operations cost on this machine, relative to a ray: the constants of gmis/transport/state/operation_costs.hpp, which choose
# counts. bench/calibrate.py says how.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/calibrate.py build/bench/examples/gmis-render "$@"

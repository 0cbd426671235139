#!/usr/bin/env bash
# Whether an error takes as long as a run says: by the forecast before it and by its log, on fourteen scenes. bench/prices.py says
# how and takes the options; it writes the table in docs/accuracy-and-time.md.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/prices.py --renderer build/bench/examples/gmis-render "$@"

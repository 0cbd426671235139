#!/usr/bin/env bash
# Lights chosen by a learned table (bench/light_table.cpp says how). Without arguments the table in docs/weights.md.
#
# Usage: bench/light_table.sh [ITERATIONS [SIZE [SCENE.pbrt ...]]]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench >/dev/null
cmake --build --preset bench --target light_table >/dev/null
program=build/bench/bench/light_table
if (($#)); then exec "$program" "$@"; fi

mkdir -p out/light_table
"$program" | tee out/light_table/table.md
python3 bench/put_table.py docs/weights.md "light table" "./run bench light_table" out/light_table/table.md

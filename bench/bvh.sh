#!/usr/bin/env bash
# The built-in tree beside Embree 3 (bench/bvh.cpp says how). Without arguments: five meshes of a hundred thousand to a million
# triangles, then of ten times as many, written into docs/bvh.md.
#
# Usage: bench/bvh.sh [--scale S] [--size PIXELS] [--rounds N] [--threads N] [--mesh NAME]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench >/dev/null
cmake --build --preset bench --target bvh >/dev/null
program=build/bench/bench/bvh
if (($#)); then exec "$program" "$@"; fi

mkdir -p out/bvh
"$program" | tee out/bvh/table.md
"$program" --scale 10 --rounds 2 | tee out/bvh/ten_times.md
if grep -q "over Embree" out/bvh/table.md; then
  python3 bench/put_table.py docs/bvh.md bvh "./run bench bvh" out/bvh/table.md
  python3 bench/put_table.py docs/bvh.md "ten times" "./run bench bvh" out/bvh/ten_times.md
fi

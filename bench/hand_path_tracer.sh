#!/usr/bin/env bash
# Instructions an iteration of the engine as path tracer (pt) and of a path tracer written by hand over the same scene
# (bench/hand/path_tracer.hpp), counted by callgrind: the difference between runs of 3 and of 1 iterations. Both make the
# same pictures but for rounding, which is checked first. Fails when the engine takes more than 2 % more.
#
# Usage: bench/hand_path_tracer.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench >/dev/null
cmake --build --preset bench --target hand_path_tracer >/dev/null
program=build/bench/bench/hand_path_tracer

instructions_of() { # way scene iterations
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "$program" "$1" "$2" "$3" 2>&1 |
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}
per_iteration() { # way scene
  echo $((($(instructions_of "$1" "$2" 3) - $(instructions_of "$1" "$2" 1)) / 2))
}

status=0
printf '%-7s %20s %20s %7s\n' scene 'by hand, M instr/it.' 'pt, M instr/it.' ratio
for scene in box glossy sky point; do
  awk -v a="$("$program" hand "$scene" 4)" -v b="$("$program" pt "$scene" 4)" \
    'BEGIN { exit !(a > 0 && (a - b) ^ 2 < (1e-6 * a) ^ 2) }' ||
    { echo "the two pictures of $scene differ" >&2; exit 1; }
  awk -v s="$scene" -v h="$(per_iteration hand "$scene")" -v p="$(per_iteration pt "$scene")" \
    'BEGIN { printf "%-7s %20.2f %20.2f %7.4f\n", s, h / 1e6, p / 1e6, p / h; exit p > 1.02 * h }' || status=1
done
exit $status

#!/usr/bin/env bash
# Instructions a round of N3 by `estimate` and by a loop of one's own with the same checks and sums (bench/own_loop/loops.hpp),
# counted by callgrind: the difference between runs of 3000 and of 1000 rounds. Both have the same mean, which is checked
# first. Fails when `estimate` takes more than 2 % more. The last lines: densities without a call, by `pdf` and by `pdfs`.
#
# Usage: bench/own_loop.sh [g++|clang++]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
compiler=${1:-g++}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$compiler" -std=c++20 -O3 -DNDEBUG -I include -I bench bench/own_loop/main.cpp -o "$folder/own_loop"

instructions_of() { # way kind n rounds
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "$folder/own_loop" "$@" 2>&1 |
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}
per_round() { # way kind n
  echo $((($(instructions_of "$@" 3000) - $(instructions_of "$@" 1000)) / 2))
}

status=0
printf '%-13s %4s %14s %14s %7s   (%s, instructions a round)\n' proposals N 'by hand' estimate ratio "$compiler"
for kind in static dynamic one-by-one side-by-side; do
  sizes="1 2 4 8 16 64"
  [[ $kind != *-by-* ]] || sizes=64
  for n in $sizes; do
    awk -v a="$("$folder/own_loop" hand $kind "$n" 500)" -v b="$("$folder/own_loop" library $kind "$n" 500)" \
      'BEGIN { split(a, x); split(b, y); exit !(x[1] > 0 && (x[1] - y[1]) ^ 2 < (1e-9 * x[1]) ^ 2 && x[3] == 0 && y[3] == 0) }' ||
      { echo "the two means of $kind $n differ" >&2; exit 1; }
    awk -v k=$kind -v n="$n" -v h="$(per_round hand $kind "$n")" -v l="$(per_round library $kind "$n")" \
      'BEGIN { printf "%-13s %4d %14.1f %14.1f %7.4f\n", k, n, h / 1e3, l / 1e3, l / h; exit l > 1.02 * h }' || status=1
  done
done
exit $status

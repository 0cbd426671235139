#!/usr/bin/env bash
# Instructions a round of N3 by `estimate` and by a loop of one's own with the same checks and sums (bench/own_loop/loops.hpp),
# counted by callgrind: the difference between runs of 3000 and of 1000 rounds (300 and 100 for large N). Both have the same mean, which is checked
# first. Fails when `estimate` takes more than 2 % more. The last lines: vector instructions, over densities side by side and
# over batches of samples, beside the same loop by hand. OWN_LOOP_FLAGS are passed to the compiler (-march=x86-64-v3).
#
# Usage: bench/own_loop.sh [g++|clang++]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
compiler=${1:-g++}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# shellcheck disable=SC2086 # one word per flag
"$compiler" -std=c++20 -O3 -DNDEBUG -ffp-contract=off ${OWN_LOOP_FLAGS:-} -I include -I bench bench/own_loop/main.cpp -o "$folder/own_loop"

instructions_of() { # way kind n rounds
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "$folder/own_loop" "$@" 2>&1 |
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}
per_round() { # way kind n
  local thousandths=1000
  if (($3 > 8)); then thousandths=100; fi
  echo $((($(instructions_of "$@" $((3 * thousandths))) - $(instructions_of "$@" $thousandths)) * (1000 / thousandths) / 2))
}

status=0
printf '%-19s %4s %14s %14s %7s   (%s, instructions a round)\n' proposals N 'by hand' estimate ratio "$compiler"
for kind in ${OWN_LOOP_KINDS:-static dynamic cauchy cauchy-side-by-side cauchy-batches side-by-side batches}; do
  sizes=${OWN_LOOP_SIZES:-1 2 4 8 16 64}
  for n in $sizes; do
    awk -v a="$("$folder/own_loop" hand $kind "$n" 500)" -v b="$("$folder/own_loop" library $kind "$n" 500)" \
      'BEGIN { split(a, x); split(b, y); exit !(x[1] > 0 && (x[1] - y[1]) ^ 2 < (1e-9 * x[1]) ^ 2 && x[3] == 0 && y[3] == 0) }' ||
      { echo "the two means of $kind $n differ" >&2; exit 1; }
    awk -v k=$kind -v n="$n" -v h="$(per_round hand $kind "$n")" -v l="$(per_round library $kind "$n")" \
      'BEGIN { printf "%-19s %4d %14.1f %14.1f %7.4f\n", k, n, h / 1e3, l / 1e3, l / h; exit (k ~ /^(static|dynamic)$/) && l > 1.02 * h }' ||
      status=1
  done
done
exit $status

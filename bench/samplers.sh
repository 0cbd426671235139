#!/usr/bin/env bash
# Low-discrepancy numbers beside independent ones: squared relative error and processor time, with --sampler sobol over
# --sampler independent, on fourteen scenes. Errors are those that the runs state (relMSE, without the worst 0.1 % of the pixels
# in brackets), the mean over seeds; with `sobol` they come from 8 replications, as any user of the option sees them.
#
# Usage: bench/samplers.sh [SCENE…]   (SEEDS=4, ITERATIONS=64, SIZE=64x64, INTEGRATORS='pt vcm auto' in the environment)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
render=build/bench/examples/gmis-render
seeds=${SEEDS:-4} iterations=${ITERATIONS:-64} size=${SIZE:-64x64}
read -ra integrators <<<"${INTEGRATORS:-pt vcm auto}"
scenes=("$@")
if ((!$#)); then scenes=(cornell paper1 paper2 paper3 paper4 bench/scenes/*.pbrt); fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

statistic() { # key
  sed -n "s/.*\"$1\": *\([-+.0-9e]*\).*/\1/p" "$folder/stats.json" | head -n 1
}
# Squared relative error, the same trimmed, processor seconds: means over the seeds.
run() { # scene integrator sampler
  local seed
  for ((seed = 1; seed <= seeds; ++seed)); do
    "$render" "$1" --integrator "$2" --sampler "$3" --seed "$seed" --size "$size" --iterations "$iterations" --threads 1 \
      --quiet --stats "$folder/stats.json" --out "$folder/out.pfm"
    echo "$(statistic relative_error) $(statistic relative_error_trimmed) $(statistic cpu)"
  done | awk '{ e += $1 ^ 2; t += $2 ^ 2; c += $3 } END { print e / NR, t / NR, c / NR }'
}

printf '%-20s %-5s %22s %22s %8s %12s   (%d iterations, %s, %d seeds)\n' scene '' 'independent' 'sobol' ratio 'CPU time' \
  "$iterations" "$size" "$seeds"
for scene in "${scenes[@]}"; do
  for integrator in "${integrators[@]}"; do
    independent=$(run "$scene" "$integrator" independent)
    sobol=$(run "$scene" "$integrator" sobol)
    awk -v s="$(basename "$scene" .pbrt)" -v i="$integrator" -v a="$independent" -v b="$sobol" 'BEGIN {
      split(a, x, " "); split(b, y, " ")
      printf "%-20s %-5s %10.5f (%9.5f) %10.5f (%9.5f) %.2f (%.2f) %6.2f\n",
        s, i, x[1], x[2], y[1], y[2], y[1] / x[1], y[2] / x[2], y[3] / x[3] }'
  done
done

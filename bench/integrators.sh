#!/usr/bin/env bash
# Every integrator on every paper scene for the same time: relMSE against a converged reference, iterations, seconds an
# iteration. Prints a table in Markdown, also to out/integrators/table.md.
#
# The reference of a scene is the mean of two long runs of vcm with other seeds and a quarter of the usual merging radius, so
# a sixteenth of its bias: the sun's caustics seen in mirrors are out of reach of any unbiased integrator here. The relMSE of
# the two runs against each other is four times what noise the reference itself has. References are kept in
# out/integrators and used again.
#
# Usage: bench/integrators.sh [--time SECONDS] [--reference-time SECONDS] [--seeds N] [--size WxH] [--scenes "NAME …"]
#   --time            of a cell and seed (10), on all cores
#   --reference-time  of each of the two runs of a reference (120)
#   --seeds           runs of a cell; the table has their mean (2)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=10 reference_seconds=120 seeds=2 size=128x128 scenes="paper1 paper2 paper3 paper4"
while (($#)); do
  (($# > 1)) || { echo "integrators.sh: $1 needs a value" >&2; exit 2; }
  case $1 in
    --time) seconds=$2 ;;
    --reference-time) reference_seconds=$2 ;;
    --seeds) seeds=$2 ;;
    --size) size=$2 ;;
    --scenes) scenes=$2 ;;
    *) echo "integrators.sh: no option $1; see the head of $0" >&2; exit 2 ;;
  esac
  shift 2
done

cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
render=build/bench/examples/gmis-render
folder=out/integrators
mkdir -p "$folder"
table=$folder/table.md

statistic() { # file key
  sed -n "s/.*\"$2\": *\([-+.0-9e]*\).*/\1/p" "$1" | head -n 1
}

# The mean of two PFM files of one size.
mean_of() { # a b result
  python3 - "$@" <<'END'
import array, sys
def read(name):
    data = open(name, "rb").read()
    head, rest = data.split(b"\n", 3)[:3], data.split(b"\n", 3)[3]
    values = array.array("f", rest)
    if (float(head[2]) < 0) != (sys.byteorder == "little"): values.byteswap()
    return head, values
(head, a), (_, b) = read(sys.argv[1]), read(sys.argv[2])
mean = array.array("f", ((x + y) / 2 for x, y in zip(a, b)))
scale = b"-1.0" if sys.byteorder == "little" else b"1.0"
open(sys.argv[3], "wb").write(head[0] + b"\n" + head[1] + b"\n" + scale + b"\n" + mean.tobytes())
END
}

reference_of() { # scene; prints how well its two halves agree
  local name=$folder/${1}_$size
  if [[ ! -e $name.pfm || ! -e $name.json ]]; then
    "$render" "$1" --size "$size" --integrator vcm --seed 1000001 --radius 0.1 --time "$reference_seconds" --quiet \
      --out "${name}_a.pfm"
    "$render" "$1" --size "$size" --integrator vcm --seed 2000002 --radius 0.1 --time "$reference_seconds" --quiet \
      --reference "${name}_a.pfm" --out "${name}_b.pfm" --stats "$name.json"
    mean_of "${name}_a.pfm" "${name}_b.pfm" "$name.pfm"
  fi
  awk -v e="$(statistic "$name.json" relmse)" -v t="$(statistic "$name.json" relmse_trimmed)" \
    'BEGIN { printf "%.2g (trimmed %.2g)", e, t }'
}

# integrator, and how it is asked for
integrators=(
  "pt|--integrator pt"
  "lt|--integrator lt"
  "bpt|--integrator bpt"
  "ppm|--integrator ppm"
  "bpm|--integrator bpm"
  "vcm|--integrator vcm"
  "gmis, local|--integrator gmis --split local"
  "gmis, budgeted|--integrator gmis --split budgeted"
  "gmis, adaptive|--integrator gmis --split adaptive"
)

say() { printf '%s\n' "$*" | tee -a "$table"; }
: >"$table"
say "$size pixels, $seconds s a run, the mean of $seeds runs; $(nproc) threads, g++ -O3 -march=x86-64-v3, $(date -u +%F)."
for scene in $scenes; do
  agreement=$(reference_of "$scene")
  say ""
  say "**$scene**; the two halves of its reference differ by a relMSE of $agreement."
  say ""
  say "| integrator | relMSE | relMSE, trimmed | iterations | ms an iteration |"
  say "| --- | --- | --- | --- | --- |"
  for entry in "${integrators[@]}"; do
    : >"$folder/cells"
    for ((seed = 1; seed <= seeds; ++seed)); do
      # shellcheck disable=SC2086 # several words
      "$render" "$scene" --size "$size" ${entry#*|} --seed "$seed" --time "$seconds" --quiet \
        --reference "$folder/${scene}_$size.pfm" --out "$folder/cell.pfm" --stats "$folder/cell.json"
      echo "$(statistic "$folder/cell.json" relmse) $(statistic "$folder/cell.json" relmse_trimmed)" \
        "$(statistic "$folder/cell.json" iterations) $(statistic "$folder/cell.json" wall)" >>"$folder/cells"
    done
    say "$(awk -v name="${entry%%|*}" '
      { e += $1; t += $2; n += $3; s += $4 }
      END { printf "| %s | %.3g | %.3g | %.0f | %.1f |", name, e / NR, t / NR, n / NR, 1000 * s / n }' "$folder/cells")"
  done
done
say ""
say "\`lt\` does not make what is seen in mirrors or through glass: where there are some, its error is what is missing there."
say "\`ppm\`, \`bpm\`, \`vcm\` and \`gmis\` merge, with a radius that shrinks from 0.4 pixel widths (gmis, local: 3.2)."

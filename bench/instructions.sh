#!/usr/bin/env bash
# Instructions an iteration of all integrators and error an iteration of pt, bpt and vcm on svcm0 and svcm1 (128×128, 10 segments), beside the
# figures of SmallVCM for the same settings (tests/program/reference/README.md). Instructions, counted by callgrind, because
# seconds differ from machine to machine: the difference between runs of 3 and of 1 iterations, so that reading the scene
# and building its tree do not count.
#
# Usage: bench/instructions.sh [instructions|parts|errors|--check|--keep]   (default: instructions, then errors)
#   instructions   also writes its table into docs/smallvcm.md
#   parts          where the instructions go, by part of the library (instruction_parts.py); writes its table into docs/smallvcm.md
#   --check        counts small pictures anew (instructions/main.cpp: the engines alone) and compares with the figures kept in bench/instructions.txt: fails when one is
#                  above by more than 1 %. The level of the processor is fixed (preset bench: x86-64-v3), and valgrind shows every
#                  program the same processor, so the figures depend on the compiler and the C library, not on the machine.
#   --keep         counts them and keeps the figures
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
what=${1:-both}
kept=bench/instructions.txt
case $what in
  both | instructions | parts | errors | --check | --keep) ;;
  *)
    echo "instructions: no $what: instructions, parts, errors, --check or --keep" >&2
    exit 2
    ;;
esac
if [[ -r /proc/cpuinfo ]] && ! grep -qE '^flags.* avx2 .*' /proc/cpuinfo; then
  echo "instructions: this processor has no AVX2: nothing is counted" >&2
  exit 0
fi
cmake --preset bench >/dev/null
case $what in
  --* | parts) cmake --build --preset bench --target instruction_counts >/dev/null ;;
  *) cmake --build --preset bench --target gmis-render >/dev/null ;;
esac
if [[ $what == parts ]]; then exec python3 bench/instruction_parts.py build/bench/bench/instruction_counts; fi
render=build/bench/examples/gmis-render
reference=tests/program/reference
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# The settings of SmallVCM, whose numbers are independent and which connects with every vertex of one light path: half the diagonal of its bounding box is 2.21705961, radius 0.003 of it, α = 0.75.
connections() { # integrator
  case "$1" in bpt | vcm) echo "--connections paired" ;; esac
}
settings=(--max-depth 10 --alpha 0.75 --radius 0.00665118u --threads 1 --quiet --sampler independent)

# scene integrator → millions of instructions an iteration of SmallVCM
smallvcm_instructions() {
  case "$1 $2" in
    'svcm0 pt') echo 203 ;; 'svcm0 lt') echo 112 ;; 'svcm0 ppm') echo 145 ;;
    'svcm0 bpm') echo 283 ;; 'svcm0 bpt') echo 385 ;; 'svcm0 vcm') echo 414 ;;
    'svcm1 pt') echo 223 ;; 'svcm1 lt') echo 207 ;; 'svcm1 ppm') echo 201 ;;
    'svcm1 bpm') echo 334 ;; 'svcm1 bpt') echo 572 ;; 'svcm1 vcm') echo 608 ;;
  esac
}

# scene integrator iterations → relMSE of SmallVCM, and without the worst 0.1 % of the pixels (mean of 3 seeds)
smallvcm_error() {
  case "$1 $2 $3" in
    'svcm0 pt 1') echo 2.42 .429 ;; 'svcm0 pt 4') echo .599 .228 ;; 'svcm0 pt 16') echo .171 .123 ;;
    'svcm0 pt 64') echo .0749 .0688 ;;
    'svcm0 bpt 1') echo 1.91 .491 ;; 'svcm0 bpt 4') echo .446 .164 ;; 'svcm0 bpt 16') echo .204 .0548 ;;
    'svcm0 bpt 64') echo .0417 .0232 ;;
    'svcm0 vcm 1') echo 1.38 .604 ;; 'svcm0 vcm 4') echo .464 .205 ;; 'svcm0 vcm 16') echo .0995 .0638 ;;
    'svcm0 vcm 64') echo .0335 .0231 ;;
    'svcm1 pt 1') echo 17.1 2.44 ;; 'svcm1 pt 4') echo 4.16 2.23 ;; 'svcm1 pt 16') echo 1.03 .838 ;;
    'svcm1 pt 64') echo .248 .222 ;;
    'svcm1 bpt 1') echo 1.80 .165 ;; 'svcm1 bpt 4') echo .468 .0518 ;; 'svcm1 bpt 16') echo .108 .0312 ;;
    'svcm1 bpt 64') echo .0265 .0163 ;;
    'svcm1 vcm 1') echo .319 .191 ;; 'svcm1 vcm 4') echo .0902 .0652 ;; 'svcm1 vcm 16') echo .0243 .0198 ;;
    'svcm1 vcm 64') echo .0073 .0060 ;;
  esac
}

instructions_of() { # scene integrator iterations
  # shellcheck disable=SC2046 # two words or none
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "$render" "$reference/$1.pbrt" --integrator "$2" \
    $(connections "$2") "${settings[@]}" --iterations "$3" --out "$folder/out.pfm" 2>&1 |
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}

statistic() { # file key
  sed -n "s/.*\"$2\": *\([-+.0-9e]*\).*/\1/p" "$1" | head -n 1
}

# --- Figures kept -------------------------------------------------------------------------------------------------------

compiler() { echo "$(basename "${CXX:-g++}") $(${CXX:-g++} -dumpfullversion -dumpversion)"; }
small_figures() {
  local scene integrator n counts
  for scene in svcm0 svcm1; do
    for integrator in pt lt ppm bpm bpt vcm; do
      counts=()
      for n in 1 2; do
        counts+=("$(valgrind --tool=callgrind --callgrind-out-file=/dev/null build/bench/bench/instruction_counts \
          "$reference/$scene.pbrt" "$integrator" $n 48 2>&1 | sed -n 's/.*Collected : \([0-9]*\).*/\1/p')")
      done
      awk -v s=$scene -v i=$integrator -v a="${counts[0]}" -v b="${counts[1]}" \
        'BEGIN { printf "%s %s %.3f\n", s, i, (b - a) / 1e6 }'
    done
  done
}
if [[ $what == --keep ]]; then
  small_figures >"$folder/figures"
  {
    echo "# Millions of instructions an iteration, 48x48 pixels. Written by ./run bench instructions --keep; checked by --check."
    echo "# $(compiler)"
    cat "$folder/figures"
  } >$kept
  cat $kept
  exit
fi
if [[ $what == --check ]]; then
  if [[ $(sed -n 2p $kept) != "# $(compiler)" ]]; then
    echo "instructions: the figures kept are those of $(sed -n '2s/# //p' $kept), this is $(compiler): not compared" >&2
    exit 0
  fi
  small_figures | awk '
    NR == FNR { if ($1 != "#") kept[$1 " " $2] = $3; next }
    {
      key = $1 " " $2
      change = key in kept ? 100 * ($3 / kept[key] - 1) : 0
      grown = !(key in kept) || change > 1
      printf "%-6s %-4s %9.3f  kept %9.3f  %+6.2f %%%s\n", $1, $2, $3, kept[key], change, grown ? "  GROWN" : ""
      failed = failed || grown
    }
    END { exit failed }' $kept - || {
    echo "instructions: a figure grew by more than 1 %. Find out why; if it must be, ./run bench instructions --keep" >&2
    exit 1
  }
  exit
fi

# --- Beside SmallVCM ----------------------------------------------------------------------------------------------------

if [[ $what != errors ]]; then
  printf '%-6s %-4s %12s %12s %7s\n' scene '' 'M instr/it.' 'SmallVCM' ratio
  for scene in svcm0 svcm1; do
    for integrator in pt lt ppm bpm bpt vcm; do
      one=$(instructions_of "$scene" "$integrator" 1)
      three=$(instructions_of "$scene" "$integrator" 3)
      awk -v s="$scene" -v i="$integrator" -v a="$one" -v b="$three" -v r="$(smallvcm_instructions "$scene" "$integrator")" \
        'BEGIN { m = (b - a) / 2e6; printf "%-6s %-4s %12.1f %12d %7.2f\n", s, i, m, r, m / r }' | tee -a "$folder/table"
    done
  done
  # Into the document, between the head of its table and the next empty line.
  awk -v table="$folder/table" '
    /^\| scene \| integrator \| gmis \| SmallVCM \| ratio \|$/ { head = 1 }
    !head || !NF { if (head == 3 && !NF) head = 0; print; next }
    head < 3 { print; ++head }
    head == 3 && !written { written = 1; while ((getline line < table) > 0) { split(line, f); printf "| %s | %s | %s | %s | %s |\n", f[1], f[2], f[3], f[4], f[5] } }
  ' docs/smallvcm.md >"$folder/document"
  cp "$folder/document" docs/smallvcm.md
fi

if [[ $what != instructions ]]; then
  [[ $what == errors ]] || echo
  seeds=${SEEDS:-8}
  printf '%-6s %-4s %10s %29s %20s   (relMSE, in brackets trimmed; ours: mean of %d seeds ± its standard error)\n' scene '' iterations ours SmallVCM "$seeds"
  for scene in svcm0 svcm1; do
    for integrator in pt bpt vcm; do
      for iterations in 1 4 16 64; do
        : >"$folder/errors"
        for ((seed = 1; seed <= seeds; ++seed)); do
          # shellcheck disable=SC2046 # two words or none
          "$render" "$reference/$scene.pbrt" --integrator "$integrator" $(connections "$integrator") --max-depth 10 --alpha 0.75 --radius 0.00665118u --quiet \
            --iterations "$iterations" --seed "$seed" --reference "$reference/$scene.pfm" --stats "$folder/stats.json" \
            --out "$folder/out.pfm"
          echo "$(statistic "$folder/stats.json" relmse) $(statistic "$folder/stats.json" relmse_trimmed)" >>"$folder/errors"
        done
        # shellcheck disable=SC2046
        awk -v s="$scene" -v i="$integrator" -v n="$iterations" -v r="$(smallvcm_error "$scene" "$integrator" "$iterations")" '
          { e += $1; t += $2; squares += $2 * $2 }
          END {
            split(r, ref, " ")
            spread = squares / NR - (t / NR) ^ 2
            printf "%-6s %-4s %10d %9.4f (%8.4f ± %6.4f) %9.4f (%8.4f)\n", s, i, n, e / NR, t / NR,
              sqrt((spread > 0 ? spread : 0) / (NR > 1 ? NR - 1 : 1)), ref[1], ref[2]
          }' \
          "$folder/errors"
      done
    done
  done
fi

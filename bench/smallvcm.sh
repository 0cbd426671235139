#!/usr/bin/env bash
# Efficiency of --integrator auto beside SmallVCM's own algorithms on its four scenes. Takes the path of a checkout of SmallVCM, which is no part of
# this project; bench/smallvcm.py says how and takes the options.
set -euo pipefail
if (($# == 0)); then
  echo "smallvcm: give the path of a checkout of SmallVCM: nothing is measured" >&2
  exit 0
fi
checkout=$(realpath "$1")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake --preset bench --log-level=WARNING >/dev/null
cmake --build --preset bench --target gmis-render >/dev/null
exec python3 bench/smallvcm.py --renderer build/bench/examples/gmis-render "$checkout" "${@:2}"

#!/usr/bin/env bash
# The engine inside SmallVCM: over its intersection, BSDFs, lights and camera, beside its own integrators in the same program, by instructions a
# pixel. Takes the path of a checkout of SmallVCM, which is no part of this project; bench/embedded.py says how.
#
# Usage: bench/embedded.sh CHECKOUT
set -euo pipefail
if (($# == 0)); then
  echo "embedded: give the path of a checkout of SmallVCM: nothing is measured" >&2
  exit 0
fi
checkout=$(realpath -m "$1")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec python3 bench/embedded.py "$checkout" "${@:2}"

#!/bin/sh
# Renders a scene by tasks that each take a part of the iterations, and joins them.
# Usage: render_parts.sh PICTURE TASKS AT-ONCE ITERATIONS-OF-A-TASK SCENE [OPTION ...]
set -eu
picture=$1 tasks=$2 at_once=$3 each=$4
shift 4
seq "$tasks" | xargs -P "$at_once" -I{} sh -c '
  task=$1 tasks=$2 each=$3 picture=$4
  shift 4
  gmis-render "$@" --iterations $(((task - 1) * each + 1))..$((task * each))/$((tasks * each)) \
    --checkpoint "$picture.$task.checkpoint" --out "$picture.$task.pfm" --quiet
' task {} "$tasks" "$each" "$picture" "$@"
task=0
while [ $task -lt "$tasks" ]; do
  task=$((task + 1))
  set -- "$@" --resume "$picture.$task.checkpoint"
done
gmis-render "$@" --out "$picture"

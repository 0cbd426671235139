#!/usr/bin/env bash
# Lights chosen for their receiver: the variance of pictures at equal samples beside lights chosen by power, and instructions of
# a next event (its receiver by a ray, choice, point on the light, shadow ray) among 10, 1000 and 100000 lamps, counted by
# callgrind in the loop alone. Fails when one among 100000 lamps takes more than 4 times as many as among 10.
#
# Usage: bench/light_choice.sh [gains|instructions]   (default: both)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
what=${1:-both}
cmake --preset bench >/dev/null
cmake --build --preset bench --target light_choice >/dev/null
program=build/bench/bench/light_choice

[[ $what == instructions ]] || "$program"
[[ $what == gains ]] && exit

events=20000
per_event() { # lights selection
  local all
  all=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null '--toggle-collect=*next_events*' "$program" loop "$1" "$2" "$events" 2>&1 |
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p')
  echo $((all / events))
}
printf '%-10s %12s %12s   instructions of a next event\n' lamps 'by power' 'by receiver'
for lights in 10 1000 100000; do
  by_receiver=$(per_event "$lights" by_receiver)
  printf '%-10s %12d %12d\n' "$lights" "$(per_event "$lights" by_power)" "$by_receiver"
  [[ $lights == 10 ]] && least=$by_receiver
done
awk -v few="$least" -v many="$by_receiver" 'BEGIN { printf "100000 lamps over 10: %.2f\n", many / few; exit many > 4 * few }'

#!/bin/sh
# test.sh PROGRAM [OPTION ...]: the button is listed, and in the demo it is felt and clicks.
set -u
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1

"$@" apps | grep '^button ' || { echo "the button is not listed"; exit 1; }
"$@" demo --app button --headless --quick --seed 1 --out report > told 2>&1 || { cat told; exit 1; }
cat told
# The force rises to the snap, falls by more than a third within 15 ms, and is there again at the stop.
awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; if (!("given_n" in column)) { print "no given_n"; exit 1 }; next }
  { f[NR % 15] = $column["given_n"]; n = NR; old = f[(NR + 1) % 15]; if (old > 1.2 && $column["given_n"] < old * 0.66) snapped = 1 }
  END { print snapped ? "it snapped" : "it never snapped"; exit !snapped }' report/raw/haptics.csv

#!/bin/sh
# test.sh PROGRAM [OPTION ...]: the jelly is listed, and plays the demo: calibrated, in lock-step, in real time.
set -u
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1

"$@" apps | grep '^jelly ' || { echo "the jelly is not listed"; exit 1; }
"$@" demo --app jelly --headless --quick --out report > told 2>&1 || { cat told; exit 1; }
cat told
grep -q '^jelly: .*[1-9][0-9]* presses' told || exit 1
ls report/pictures/*press*.png || exit 1
# The dent as it was shown: 2 mm and more.
awk -F, 'NR > 1 && $3 > most { most = $3 } END { print "deepest dent " most " mm"; exit !(most > 2) }' report/raw/jelly.csv

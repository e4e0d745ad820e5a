#!/bin/sh
# test.sh PROGRAM [OPTION ...]: the driver is among the cameras, and pictures come through its pipe as they were sent.
set -u
folder=$(mktemp -d) || exit 1
writer=
trap 'rm -rf "$folder"; [ -z "$writer" ] || kill "$writer" 2> /dev/null' EXIT
cd "$folder" || exit 1

"$@" camera record --help | grep -q 'ppm:PATH of a pipe' || { echo "the driver is not among the cameras"; exit 1; }
"$@" camera record ppm:nowhere --out a 2> said; [ $? -eq 1 ] && grep -q mkfifo said || { cat said; exit 1; }

mkfifo eye
picture() { printf 'P6\n32 16\n255\n'; head -c 1536 /dev/zero | tr '\0' "$1"; }
{ while :; do picture x; sleep 0.05; done > eye; } 2> /dev/null &
writer=$!
"$@" camera record ppm:eye --seconds 2 --out taken > told 2> said || { cat said; exit 1; }
cat said told
grep -q 'pictures of 32 x 16 px out of a pipe' said || exit 1
grep -q '; 0 dropped by the camera, 0 damaged' told || exit 1
[ "$(ls taken/*.png | wc -l)" -ge 3 ] || { echo "too few pictures"; exit 1; }

#!/bin/sh
# Another project, with nothing of eifmap but what `cmake --install` put somewhere, finds the client's
# library, is built with it and starts.
#   outside_project.sh BUILD_FOLDER EXAMPLES_FOLDER CMAKE
set -eu
build=$1 examples=$2 cmake=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$cmake" --install "$build" --prefix "$folder/installed" >"$folder/log"
cp -r "$examples" "$folder/outside"
"$cmake" -S "$folder/outside" -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/installed" >>"$folder/log"
"$cmake" --build "$folder/build" >>"$folder/log"
if grep -rlE '#include [<"](Eigen|opencv)' "$folder/installed/include"; then
  echo "FAILED: the headers above need more than LCM" >&2
  exit 1
fi
# An LCM that cannot be is refused with words: it links and runs.
if "$folder/build/follow_map" nothing:// 2>"$folder/said"; then
  echo "FAILED: it took nothing:// for a network" >&2
  exit 1
fi
grep -q "LCM cannot be opened" "$folder/said"

#!/bin/sh
# Bundles the page anew, from its sources and the pinned packages: the bundle that is committed must
# be the same, byte for byte. Exits 77 (skipped) without npm or a registry.
#   rebuild.sh WORK_FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
web=$here/../../client/view/web
work=$1
. "$here/npm_ci.sh"

mkdir -p "$work"
cp -R "$web/package.json" "$web/package-lock.json" "$web/build.sh" "$web/src" "$work"
npm_ci "$work"
sh "$work/build.sh" "$work/dist"
for file in view.js LICENSES.txt; do
  if ! cmp "$work/dist/$file" "$web/dist/$file"; then
    echo "FAILED: client/view/web/dist/$file is not what its sources give: npm ci && sh build.sh there"
    exit 1
  fi
done
echo "the bundle is what its sources give"

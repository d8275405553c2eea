#!/bin/sh
# The page in a real browser, with real processes, in a network of its own. Exits 77 (skipped)
# without npm, a registry, or chromium.
#   page_test.sh WORK_FOLDER SERVER CLIENT [SCREENSHOT [IMAGES]]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$1
shift
. "$here/npm_ci.sh"

chromium=$(command -v chromium || true)
if [ -z "$chromium" ] || ! command -v node >/dev/null; then
  echo "skipped: there is no chromium, or no node (docker/packages_optional.txt has them)"
  exit 77
fi
mkdir -p "$work"
cp "$here"/package.json "$here"/package-lock.json "$here"/*.mjs "$work"
npm_ci "$work"
exec "$here/../support/private_network.sh" node "$work/page_test.mjs" "$chromium" "$work" "$@"

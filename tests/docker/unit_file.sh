#!/bin/sh
# systemd has nothing to say against the unit file; of what is misspelt it would.
#   unit_file.sh SERVER_BINARY
set -eu
unit="$(cd "$(dirname "$0")/../.." && pwd)/docker/eifmap-server.service"
if ! command -v systemd-analyze >/dev/null 2>&1; then
  echo "skipped: there is no systemd-analyze"
  exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# What systemd says of the unit with a line changed as by sed. The binary is where it was built.
verdict() {
  sed -e "s|/usr/local/bin/eifmap-server|$1|" -e "$2" "$unit" >"$folder/eifmap-server.service"
  SYSTEMD_LOG_LEVEL=warning systemd-analyze verify --man=no "$folder/eifmap-server.service" 2>&1 |
    grep -F eifmap-server || true
}

said=$(verdict "$1" '')
if [ -n "$said" ]; then
  echo "FAILED: $said"
  exit 1
fi
if [ -z "$(verdict "$1" 's/^Restart=.*/Restrat=always/')" ]; then
  echo "FAILED: a misspelt line was not found: this shows nothing"
  exit 1
fi
grep -q '^Restart=' "$unit" || { echo "FAILED: nothing restarts the server"; exit 1; }
echo "the unit file is sound"

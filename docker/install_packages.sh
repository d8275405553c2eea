#!/bin/sh
# Installs the Debian packages of packages.txt that are missing: nothing to do, nothing done.
set -eu
here=$(cd "$(dirname "$0")" && pwd)

wanted=$(sed 's/#.*//' "$here/packages.txt" | tr -s '[:space:]' '\n' | sed '/^$/d' | sort -u)
if ! command -v dpkg-query >/dev/null 2>&1; then
  echo "This is not Debian. Please install what corresponds to these packages of Debian 12:" >&2
  echo "$wanted" | tr '\n' ' ' | fold -s -w 96 >&2
  echo >&2
  # Somebody who has installed them goes on from here.
  exit 0
fi

# shellcheck disable=SC2086  # words on purpose: one package each
installed=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' $wanted 2>/dev/null |
  sed -n 's/ installed$//p' | sort -u)
missing=
for package in $wanted; do
  case "
$installed
" in
    *"
$package
"*) ;;
    *) missing="$missing $package" ;;
  esac
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if command -v sudo >/dev/null 2>&1 && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
    as_root=sudo
  else
    echo "Packages are missing, and only root can install them. As root, please run:" >&2
    echo "  apt-get update && apt-get install --no-install-recommends$missing" >&2
    exit 1
  fi
fi

echo "Installing:$missing"
export DEBIAN_FRONTEND=noninteractive
$as_root apt-get update -q
# shellcheck disable=SC2086
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing

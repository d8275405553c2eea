#!/bin/sh
# Runs a command in a network of its own: nothing but loopback, with the multicast route that LCM
# needs, so that no datagram leaves the machine. Exits 77 (skipped) where that is not allowed.
#   private_network.sh COMMAND [ARGUMENT...]
set -eu

if [ "${EIFMAP_PRIVATE_NETWORK:-}" = inside ]; then
  unset EIFMAP_PRIVATE_NETWORK
  ip link set lo up multicast on
  ip route add 224.0.0.0/4 dev lo
  exec "$@"
fi

if [ "$(id -u)" = 0 ]; then
  unshare="unshare --net"
else
  unshare="unshare --map-root-user --net"
fi
if ! command -v ip >/dev/null || ! $unshare ip link set lo up 2>/dev/null; then
  echo "skipped: a private network needs iproute2 and the right to 'unshare --net'" >&2
  exit 77
fi
EIFMAP_PRIVATE_NETWORK=inside exec $unshare "$0" "$@"

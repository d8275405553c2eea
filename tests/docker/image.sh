#!/bin/sh
# Builds the image from docker/Dockerfile without an engine, on a Debian made by debootstrap, and
# has its server map its simulated camera. Takes some minutes; --tests runs the build stage's tests,
# too, as `docker build` does. Skipped (77) without root, debootstrap, podman and buildah.
#   image.sh [--tests]
set -eu
cd "$(dirname "$0")/../.."
tests=OFF
[ "${1:-}" != --tests ] || tests=ON
for tool in debootstrap podman buildah; do
  if [ "$(id -u)" -ne 0 ] || ! command -v $tool >/dev/null 2>&1; then
    echo "skipped: building an image here needs root, debootstrap, podman and buildah"
    exit 77
  fi
done
folder=$(mktemp -d)
store="--storage-driver vfs --root $folder/storage --runroot $folder/run"
trap 'rm -rf "$folder"' EXIT

debootstrap --variant=minbase bookworm "$folder/debian" >"$folder/debootstrap.log" 2>&1 ||
  { tail -5 "$folder/debootstrap.log"; echo "skipped: no Debian to begin with"; exit 77; }
# shellcheck disable=SC2086  # options on purpose
{
  tar -C "$folder/debian" -c . | podman $store import -q - debian:bookworm-slim
  buildah $store bud --isolation chroot --pull-never --build-arg TESTS=$tests \
    -f docker/Dockerfile -t eifmap . >"$folder/build.log" 2>&1 ||
    { tail -60 "$folder/build.log"; echo "FAILED: the image does not build"; exit 1; }
  [ $tests = OFF ] || grep -E 'tests passed|tests failed' "$folder/build.log"
  container=$(buildah $store from --pull-never eifmap)
}

cat >"$folder/job.sh" <<'JOB'
set -eu
cd /tmp
eifmap-server --version
eifmap-server --output live >server.log 2>&1 &
server=$!
eifmap log /log >log.log 2>&1 &
logger=$!
trap 'kill $server $logger 2>/dev/null || true' EXIT
sleep 2
eifmap publish --simulate courtyard --max-frames 100
sleep 3
kill -TERM $server
wait $server
sleep 1
kill -TERM $logger 2>/dev/null || true
wait
cat server.log log.log
wc -l </log/trajectory.tum >poses
JOB
cp "$folder/job.sh" "$(buildah $store mount "$container")/tmp/job.sh"
# shellcheck disable=SC2086
tests/support/private_network.sh \
  buildah $store run --isolation chroot "$container" -- sh /tmp/job.sh
poses=$(cat "$(buildah $store mount "$container")/tmp/poses")
echo "$poses of 100 images have a pose"
if [ "$poses" -lt 90 ]; then
  echo "FAILED: the image's server did not map the simulated camera"
  exit 1
fi

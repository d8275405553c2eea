#!/bin/sh
# Bundles the page into dist/, which is committed: npm ci && sh build.sh [OUTPUT_FOLDER]
set -eu
cd "$(dirname "$0")"
out=${1:-dist}
mkdir -p "$out"
node_modules/.bin/esbuild src/main.js --bundle --minify --format=iife --target=es2022 \
  --charset=utf8 --legal-comments=eof --log-level=warning --outfile="$out/view.js"
{
  echo "view.js contains parts of three.js (https://threejs.org), which is under this licence:"
  echo
  cat node_modules/three/LICENSE
} >"$out/LICENSES.txt"

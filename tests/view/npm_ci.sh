# To be sourced: npm_ci FOLDER installs what its package-lock.json says, or ends with 77 (skipped)
# where there is no npm or no registry is reached.
npm_ci() {
  if ! command -v npm >/dev/null; then
    echo "skipped: there is no npm"
    exit 77
  fi
  # Done before, of the same lock file.
  if cmp -s "$1/package-lock.json" "$1/node_modules/.installed"; then return; fi
  if ! (cd "$1" && npm ci --ignore-scripts --no-audit --no-fund --fetch-retries=1 \
    --fetch-timeout=60000 >npm.log 2>&1); then
    if grep -qE 'ENOTFOUND|EAI_AGAIN|ECONNREFUSED|ECONNRESET|ETIMEDOUT|ENETUNREACH|EHOSTUNREACH|FETCH_ERROR|network' \
      "$1/npm.log"; then
      echo "skipped: npm reaches no registry"
      exit 77
    fi
    cat "$1/npm.log"
    echo "FAILED: npm ci"
    exit 1
  fi
  cp "$1/package-lock.json" "$1/node_modules/.installed"
}

#!/usr/bin/env bash
# run_node.sh NODE SCRIPT [ARGS]: runs a Node test, or exits 77 (skipped) where the pinned packages are not installed.
set -euo pipefail
if [ ! -d node_modules/esbuild ]; then
  echo "skipped: the npm packages are not installed (npm ci, or ./dev test)"
  exit 77
fi
exec "$@"

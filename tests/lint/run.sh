#!/usr/bin/env bash
# Formatting, static checks and the page's types. Called by ./dev lint, which has installed the tools.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

sources=$(git ls-files --cached --others --exclude-standard -- '*.cpp' '*.h')

echo "== formatting"
# shellcheck disable=SC2086
clang-format-16 --dry-run --Werror $sources

echo "== include rules"
tests/structure/include_rules.sh

echo "== types of the page"
node_modules/.bin/tsc --noEmit -p display/web

echo "== static checks"
cmake --preset release >/dev/null
# Generated message headers must exist before anything can be parsed.
cmake --build --preset release --target roseau_schema
run-clang-tidy-16 -quiet -p build -extra-arg=-Wno-unknown-warning-option -j "$(nproc)" "$PWD/(core|schema|drivers|sync|recorder|replay|calib|tracking|estimation|structure|synthesis|display|daemon|bench|tests)/.*\.cpp$" \
  >/tmp/roseau-tidy.$$ 2>/dev/null || { grep -E 'warning:|error:|note:' /tmp/roseau-tidy.$$ | sort -u; rm -f /tmp/roseau-tidy.$$; exit 1; }
rm -f /tmp/roseau-tidy.$$
echo "lint is clean"

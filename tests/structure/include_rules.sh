#!/usr/bin/env bash
# Who may include whom. A folder uses only what stands in its row; a row's own folder is always allowed. Run from anywhere:
# prints every include that breaks a rule and exits 1.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

rules='
core                :
schema              : core
drivers/link        : core
drivers/wire        : core
drivers             : core drivers/link drivers/wire
sync                : core calib/model
recorder/format     : core schema
recorder            : core schema recorder/format
recorder/tools      : core schema recorder/format drivers/wire drivers
replay              : core schema recorder/format drivers/link drivers/wire
calib/model         : core
calib/detect        : core calib/model
calib               : core calib/model calib/detect
tracking            : core calib/model calib/detect
estimation          : core
structure           : core
synthesis           : core calib/model structure drivers/wire
display             : core schema
'

awk -v rules="$rules" '
  # The longest rule whose folder holds the path.
  function owner(path,   best, folder) {
    best = ""
    for (folder in allowed)
      if (index(path, folder "/") == 1 && length(folder) > length(best)) best = folder
    return best
  }
  BEGIN {
    count = split(rules, lines, "\n")
    for (i = 1; i <= count; ++i) {
      if (split(lines[i], sides, ":") < 2) continue
      gsub(/ /, "", sides[1])
      allowed[sides[1]] = " " sides[2] " "
    }
  }
  match($0, /^[ \t]*#[ \t]*include[ \t]*"[^"]+"/) {
    from = owner(FILENAME)
    if (from == "") next
    split($0, quoted, "\"")
    to = owner(quoted[2])
    if (quoted[2] ~ /^(daemon|tests|bench)\//) to = "daemon, tests or bench"
    if (to == "" || to == from || index(allowed[from], " " to " ") > 0) next
    printf "%s:%d: %s may not include %s (%s)\n", FILENAME, FNR, from, to, quoted[2]
    broken = 1
  }
  END { exit broken }
' $(git ls-files -- '*.h' '*.cpp' | grep -vE '^(tests|bench|daemon)/')
echo "include rules hold"

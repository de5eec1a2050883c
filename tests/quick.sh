#!/usr/bin/env bash
# Runs each command in its short form and looks at the exit code: 0 where nothing is refuted. quick.sh BUILD
set -euo pipefail
program="$(cd "$1" && pwd)/bipot"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
for command in "validate" "paper" "trade" "extremes --time-limit 1" "compare benchmark"; do
  name="${command%% *}"
  echo "+ bipot $command --quick"
  code=0
  "$program" $command --quick --out "$folder/$name" > "$folder/$name.log" 2>&1 < /dev/null || code=$?
  ((code == 0)) || { tail -n 40 "$folder/$name.log"; echo "bipot $command --quick ends with $code"; exit 1; }
done

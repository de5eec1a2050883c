#!/usr/bin/env bash
# Runs every block of README.md that is marked "sh runs", in a folder of its own. readme.sh SOURCE BUILD
set -euo pipefail
source="$1" build="$2"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder/build"
ln -s "$build" "$folder/build/release"
ln -s "$source/data" "$folder/data"
commands="$(awk '/^```sh runs$/ {on = 1; next} /^```$/ {on = 0} on' "$source/README.md")"
count="$(grep -c '^build/release/' <<< "$commands")"
((count >= 8)) || { echo "only $count commands found in the README"; exit 1; }
cd "$folder"
while read -r command; do
  echo "+ $command"
  bash -c "$command" > output 2>&1 < /dev/null || { cat output; echo "failed: $command"; exit 1; }
done <<< "$commands"
echo "$count commands of the README run"

#!/usr/bin/env bash
# Runs every block marked "sh runs" of README.md, of the tutorials and of the how-to pages, in one folder, as a reader
# does. There a block marked "toml NAME" of a page lies as the file NAME. readme.sh SOURCE BUILD
set -euo pipefail
shopt -s nullglob
source="$(cd "$1" && pwd)" build="$(cd "$2" && pwd)"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/build"
ln -s "$build" "$folder/build/release"
ln -s "$source/data" "$folder/data"
cd "$folder"
total=0
for page in "$source"/README.md "$source"/data/manual/tutorial/*.md "$source"/data/manual/how_to/*.md; do
  awk '/^```toml [^ ]+$/ {file = $2; next} /^```$/ {file = ""} file {print > file}' "$page"
  commands="$(awk '/^```sh runs$/ {on = 1; next} /^```$/ {on = 0} on' "$page")"
  count="$(grep -c '^build/release/' <<< "$commands" || true)"
  total=$((total + count))
  while read -r command; do
    [ -n "$command" ] || continue
    echo "+ $command"
    bash -c "$command" > output 2>&1 < /dev/null || { cat output; echo "failed: $page: $command"; exit 1; }
  done <<< "$commands"
done
((total >= 15)) || { echo "only $total commands found"; exit 1; }
echo "$total commands of the documents run, $SECONDS s"

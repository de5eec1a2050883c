#!/usr/bin/env bash
# The manual as a site in build/site/html, without a network: bench/site.sh. Needs a finished build, and of Debian 12
# mkdocs, mkdocs-material, doxygen. Each shipped scene runs for at most SCENE_SECONDS (60); runs are kept in
# build/site/runs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build="${BIPOT_BUILD:-build/release}" site=build/site
for tool in mkdocs doxygen; do
  command -v "$tool" > /dev/null || { echo "$tool is missing: apt install mkdocs mkdocs-material doxygen"; exit 1; }
done
mkdir -p "$site/runs"
for scene in data/scenes/*.toml; do
  name="$(basename "$scene" .toml)"
  [ -f "$site/runs/$name/summary.json" ] && continue
  echo "scene $name"
  "$build/bipot" run "$scene" --quiet --overwrite --time-limit "${SCENE_SECONDS:-60}" --out "$site/runs/$name" ||
    [ -f "$site/runs/$name/summary.json" ]  # a time limit ends with another code
done
rm -rf "$site/library" "$site/cpp"  # of headers that are gone
cmake --install "$build" --component library --prefix "$site/library" > /dev/null
PYTHONPATH="$build/python" /usr/bin/python3 bench/site/make_pages.py "$site"
(cd "$site" && doxygen Doxyfile > doxygen.log 2>&1)
mkdocs build --strict --clean --config-file "$site/mkdocs.yml" > "$site/mkdocs.log" 2>&1 ||
  { grep -E "WARNING|ERROR|Abort" "$site/mkdocs.log"; exit 1; }
rm "$site/html/404.html"  # its links begin at the root of a server
rm -r "$site/html/cpp" && cp -r "$site/cpp/html" "$site/html/cpp"
/usr/bin/python3 bench/site/check_links.py "$site/html"
du -sh "$site/html"
echo "to read it: python3 -m http.server --directory $site/html"

#!/usr/bin/env bash
# Installs the packages that are missing (Debian 12): .ci/install.sh [command]
# Those of packages.txt make the command. Those of test_packages.txt are for tests, packages and Python.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
lists=(packages.txt)
[ "${1:-}" = command ] || lists+=(test_packages.txt)
missing=()
while read -r package; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done < <(cat "${lists[@]}")
((${#missing[@]})) || exit 0
sudo=()
if [ "$(id -u)" -ne 0 ]; then sudo=(sudo); fi
echo "installing: ${missing[*]}"
"${sudo[@]}" apt-get update -qq
"${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"

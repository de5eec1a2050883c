#!/usr/bin/env bash
# Installs what is missing, builds, runs all tests but the long ones. Ends with ctest's summary.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash .ci/install.sh
cmake --preset release
cmake --build --preset release
ctest --preset release -j "$(($(nproc) + 1))"  # some wait, for time limits and signals

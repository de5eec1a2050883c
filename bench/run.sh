#!/usr/bin/env bash
# Installs what is missing, builds, and runs the main job on a shipped scene: bench/run.sh [SCENE] [bipot run flags]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash .ci/install.sh command
cmake --preset release -DBIPOT_WITH_TESTS=OFF
cmake --build --preset release --target bipot
scene="${1:-compaction}"
shift || true
build/release/bipot run "$scene" --overwrite "$@"

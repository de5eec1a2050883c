#!/usr/bin/env bash
# Every source that asks for an optional library compiles without all of them: an include within
# #ifdef may be needed outside. optional_parts.sh SOURCE COMPILER FLAG...
set -euo pipefail
cd "$1"
compiler=$2
shift 2
sources=$(grep -rlE '^# *if.*BIPOT_WITH_' core solvers bench --include=*.cc)
for source in $sources core/files/no_hdf5_file.cc core/linear/sparse_lu_klu.cc solvers/analysis/no_linear_programme.cc; do
  "$compiler" -std=c++20 -fsyntax-only -I. "$@" "$source"
done

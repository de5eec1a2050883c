#!/usr/bin/env bash
# Makes data/problems anew from the shipped scenes and bench/programs/make_problems.cc. Needs a release build.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bipot=build/release/bipot
folder=data/problems
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
build/release/make_problems "$folder"
dump() {  # NAME SCENE STEPS [TOLERANCE]: the problem of the last step
  "$bipot" run "$2" --steps "$3" --solver auto --tol "${4:-1e-4}" --quiet --dump-problems all --out "$work/$1"
  cp "$(ls "$work/$1"/problems/*.hdf5 | tail -n 1)" "$folder/$1.hdf5"
}
dump 1d_bouncing_ball_impact bouncing_ball 1440
dump 2d_sliding_cylinder sliding_cylinder 10
dump 2d_triangular_lattice triangular_lattice 1
dump 2d_pyramid_10 pyramid 1
dump 2d_compaction_flow compaction 250
dump 2d_compaction_rest compaction 500
dump 2d_isotropic_compression isotropic_compression 60
dump 2d_pour300_273 pour_300 273 1e-2
dump 2d_pour300_392 pour_300 392 1e-2
dump 2d_tilt1000hi_182 tilt_1000 182 1e-2
(cd "$folder" && sha256sum -- *.hdf5 > SHA256SUMS)

#!/usr/bin/env bash
# Kernels and criterion compiled for arm64 give the same bits as here. arm64.sh SOURCE PROGRAM FOLDER
# PROGRAM: kernel_bits of this machine. Debian: g++-aarch64-linux-gnu, qemu-user. Skipped, aloud, without.
set -euo pipefail
source="$1" program="$2" folder="$3"
compiler=aarch64-linux-gnu-g++
for tool in "$compiler" qemu-aarch64; do
  command -v "$tool" > /dev/null || { echo "$tool is not installed"; exit 0; }
done
mkdir -p "$folder"
cd "$source"
flags=(-std=c++20 -O1 -DNDEBUG -ffp-contract=off -DEIGEN_UNALIGNED_VECTORIZE=0 -DEIGEN_DONT_PARALLELIZE
  -DFMT_HEADER_ONLY -Wno-psabi -ffunction-sections -I. -I"$folder/include")
# Headers that do not depend on the processor, without those of this machine's system.
mkdir -p "$folder/include"
ln -sfn /usr/include/eigen3/Eigen "$folder/include/Eigen"
ln -sfn /usr/include/fmt "$folder/include/fmt"
sources=(tests/machines/kernel_bits.cc tests/support/lattice_problem.cc
  core/base/{execution,interrupt,parallel}.cc
  core/criterion/{contact_error,rounding_bound,vector_error}.cc
  core/problem/{body_rows,contact_problem,delassus,disk_structure,energy_norm,sphere_structure}.cc
  solvers/disks/{body_blocks,contact_tiles,disk_kernels,disk_kernels_portable,disk_positions}.cc
  solvers/disks/{disk_tiles,sphere_kernels_portable,tile_links,tiled_gradient,tiled_sweep}.cc
  solvers/kernels/{contact_scaling,local_coulomb}.cc)
printf '%s\n' "${sources[@]}" | xargs -P "$(nproc)" -I{} bash -c '
  object="$0/$(echo "$1" | tr / _).o"
  [ "$object" -nt "$1" ] || "${@:2}" -c "$1" -o "$object"' "$folder" {} "$compiler" "${flags[@]}"
# The factorisation of a mass matrix that is not diagonal is not compiled, and not called.
"$compiler" -static -Wl,--gc-sections,--unresolved-symbols=ignore-all "$folder"/*.o -o "$folder/kernel_bits"
"$program" > "$folder/here.txt"
qemu-aarch64 "$folder/kernel_bits" > "$folder/arm64.txt"
diff "$folder/here.txt" "$folder/arm64.txt" || { echo "other bits on arm64"; exit 1; }
echo "$(wc -l < "$folder/here.txt") hashes, the same on arm64"

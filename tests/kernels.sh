#!/usr/bin/env bash
# Looks at the symbols of the vector kernels. kernels.sh PROGRAM
set -euo pipefail
symbols=$(nm -C "$1")
for type in BodyRow GradientTask SymmetricTask; do
  grep -qE " t .*bipot::[(]anonymous namespace[)].*$type" <<< "$symbols" || { echo "no kernel takes a $type"; exit 1; }
done
parts=$(grep -E ' t .*bipot::[(]anonymous namespace[)].*(BodyRow|GradientTask|SymmetricTask).*[{]lambda' \
  <<< "$symbols" || true)
if [ -n "$parts" ]; then
  printf 'called, not inlined:\n%s\n' "$parts"
  exit 1
fi
for kernel in sum_of_plane sum_of_space project_on_plane project_on_space multiply_strips; do
  # i: an indirect function, whose level is chosen when the program is loaded.
  if ! grep -qE " i .*$kernel" <<< "$symbols"; then
    printf '%s is not chosen by the machine\n' "$kernel"
    exit 1
  fi
done

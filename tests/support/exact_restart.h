#pragma once

#include <gtest/gtest.h>

#include "core/run_files/run_reader.h"
#include "solvers/simulation/scene_run.h"
#include "tests/support/state_bits.h"
#include "tests/support/temporary_folder.h"

namespace bipot {

/// A run that stops after `at` steps and goes on from its folder ends with the bits of a whole one.
/// Returns the end. `problems`: those that the first part writes.
template <int D>
State<D> expect_exact_restart(const Scene<D>& scene, int at,
                              RunFolderOptions::Problems problems = RunFolderOptions{}.problems) {
  const TemporaryFolder folder;
  State<D> whole = initial_state(scene), part = initial_state(scene);
  run_scene(scene, whole);
  const RunFolderOptions options{.folder = folder.path() / "run", .problems = problems};
  run_scene(scene, part, {.steps = at, .folder = options});
  State<D> again = read_state<D>(options.folder);
  run_scene(scene, again, {.steps = scene.num_steps - at});
  EXPECT_EQ(bits_of_state(again), bits_of_state(whole));
  return whole;
}

}  // namespace bipot

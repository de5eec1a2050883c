#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/measure/test_problem.h"
#include "core/base/interrupt.h"
#include "core/scene/scene_family.h"

namespace bipot {

/// The families of moving_scene.h.
std::vector<std::string> moving_families();
/// Bodies of one of them: side², in space side³.
double bodies_in(const std::string& family, int side);

/// Steps of a run of a moving scene (bench/problems/moving_scene.h), counted from 1.
struct MovingRunRequest {
  std::string family;
  int side = 0;
  FamilyOptions options;
  std::vector<int> steps;  ///< wanted, increasing
  std::function<bool()> cancelled = &InterruptGuard::requested;
};

/// Steps of the run, in the order of the request. Each problem is read from its file in the cache
/// folder (FCLIB, with the start of the step as a guess). A missing or outdated file is made by one
/// run, so that every caller gets the same bits. The cache folder is $BIPOT_CACHE, else
/// $XDG_CACHE_HOME/bipot, else ~/.cache/bipot, else one in the temporary folder. Throws StepFailure
/// and FileError.
std::vector<TestProblem> moving_problems(const MovingRunRequest& request);

/// `count` steps of the run at the parts (i - 0.35) / count of it, i = 1 to count: between fall and
/// rest.
/// Throws std::invalid_argument for a family that is not one of moving_families().
std::vector<int> moving_steps(const std::string& family, int side, int count);

std::filesystem::path problem_cache_folder();

}  // namespace bipot

#pragma once

// An arrow that the fence (tests/folders.cmake) must see. Nothing compiles this file.
#include "solvers/solver.h"

#pragma once

#include <vector>

#include "bench/experiments/validation_row.h"

namespace bipot {

std::vector<ValidationExperiment> slope_experiments();     ///< one body on a floor, by hand
std::vector<ValidationExperiment> standing_experiments();  ///< three disks, four spheres, a hollow
std::vector<ValidationExperiment> impact_experiments();    ///< bouncing, swinging
std::vector<ValidationExperiment> chain_experiments();     ///< few sweeps look elastic
std::vector<ValidationExperiment> indeterminacy_experiments();  ///< admissible forces
std::vector<ValidationExperiment> packing_experiments();        ///< coordination, solid fraction
std::vector<ValidationExperiment> force_experiments();          ///< distribution of forces
std::vector<ValidationExperiment> flow_experiments();           ///< shear, collapse, drum
std::vector<ValidationExperiment> silo_experiments();           ///< Janssen

}  // namespace bipot

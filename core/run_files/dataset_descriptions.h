#pragma once

#include "core/files/hdf5_file.h"

namespace bipot {

/// Gives the datasets of run.h5 or of a frame the attribute `description`: meaning, signs, codes and
/// the rules of the indices. Each dataset with a unit has one. Throws FileError.
void add_descriptions(Hdf5File& file);

}  // namespace bipot

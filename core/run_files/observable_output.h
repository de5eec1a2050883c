#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/files/hdf5_file.h"
#include "core/motion/state.h"
#include "core/run_files/csv_file.h"

namespace bipot {

/// Files of a run's observables, in its folder:
///   observables.csv   a row a measurement, and observables_mean.csv
///   profile.csv       a row a bin and measurement, and profile_mean.csv
///   forces.csv        a row a bin and measurement, and forces_mean.csv
/// Means are over the measurements from the time on that the scene says, and are made from the files, so
/// that a run that was restarted has the same. data/manual/reference/files.md describes the columns. Throws
/// FileError.
template <int D>
class ObservableWriter {
 public:
  /// The scene asks for observables and outlives this. Rows up to `keep_up_to` of files that are there
  /// are kept.
  ObservableWriter(std::filesystem::path folder, const Scene<D>& scene, int keep_up_to);
  /// Measures where the step is due.
  void step(const State<D>& state);
  /// The means. Without effect on a run without measurements.
  void close() const;

 private:
  std::filesystem::path folder_;
  const Scene<D>& scene_;
  CsvFile rows_;
  std::optional<CsvFile> profile_;
  CsvFile forces_;
};

/// What a frame says of its state: /observables in the frame's file.
template <int D>
void write_observables(Hdf5File& file, const Scene<D>& scene, const State<D>& state);

/// A CSV file of numbers: names of the columns, and the rows. Throws FileError.
struct NumberTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
  /// Index of a column; throws std::out_of_range where there is none of that name.
  std::size_t column(const std::string& name) const;
};
NumberTable read_number_table(const std::filesystem::path& path);

}  // namespace bipot

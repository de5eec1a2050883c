#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/files/hdf5_file.h"
#include "core/motion/state.h"
#include "core/run_files/csv_file.h"

namespace bipot {

/// Writes the observables of a run into its folder:
///   observables.csv   a row for each measurement, and observables_mean.csv
///   profile.csv       a row for each bin and measurement, and profile_mean.csv
///   forces.csv        a row for each bin and measurement, and forces_mean.csv
/// Means are over the measurements after the time that the scene names. They are computed from the
/// files, so that a restarted run has the same. data/manual/reference/files.md describes the
/// columns. Throws FileError.
template <int D>
class ObservableWriter {
 public:
  /// The scene must ask for observables and outlive this object. Rows of existing files up to
  /// `keep_up_to` are kept.
  ObservableWriter(std::filesystem::path folder, const Scene<D>& scene, int keep_up_to);
  /// Rows of units.csv.
  std::string units() const;
  /// Measures if the step is due.
  void step(const State<D>& state);
  /// Writes the means. Without effect if nothing was measured.
  void close() const;

 private:
  std::filesystem::path folder_;
  const Scene<D>& scene_;
  CsvFile rows_;
  std::optional<CsvFile> profile_;
  CsvFile forces_;
};

/// What is measured, and where, as a text: rows of two runs belong together if theirs are equal.
template <int D>
std::string definition_of(const ObservableChoice<D>& choice);

/// Writes the observables of a state: /observables in the frame's file.
template <int D>
void write_observables(Hdf5File& file, const Scene<D>& scene, const State<D>& state);

/// A CSV file of numbers: names of the columns, and the rows. Throws FileError.
struct NumberTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
  /// Index of a column; throws std::out_of_range for an unknown name.
  std::size_t column(const std::string& name) const;
};
NumberTable read_number_table(const std::filesystem::path& path);

}  // namespace bipot

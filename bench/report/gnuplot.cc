#include "bench/report/gnuplot.h"

#include "bench/report/program.h"

namespace bipot {

std::string run_gnuplot(const std::string& script) {
  constexpr double kPatience = 120;  // seconds for one chart
  return run_program({"gnuplot", "--default-settings"}, script,
                     "charts are drawn by it: install the package gnuplot-nox", kPatience);
}

}  // namespace bipot

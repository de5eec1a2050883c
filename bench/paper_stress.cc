#include "bench/paper_items.h"
namespace bipot {
PaperResult run_stress(const PaperContext&) { return {}; }
}  // namespace bipot

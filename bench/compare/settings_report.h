#pragma once

#include "bench/compare/popular_settings.h"
#include "bench/report/document.h"

namespace bipot {

/// One line for each run, in the order of the study.
Table setting_rows(const SettingStudy& study);

/// "Your code's default, in ε": a table and a figure of the settings, and the meaning of tolerances.
Document settings_document(const SettingStudy& study, const Provenance& made);

}  // namespace bipot

#pragma once

#include <string>

#include "core/base/number_text.h"  // tolerance_label

namespace bipot {

/// The text of a number, 1.2e-5 where it has 1.2e-05.
std::string short_exponent(const std::string& text);
/// Without digits after the point.
std::string count_label(double count);
/// With the unit that keeps it short: 12 µs, 3.4 ms, 5 s; a dash if not finite.
std::string seconds_label(double seconds);
/// The same, in minutes from 120 s on.
std::string duration_label(double seconds);
/// As compact_label, but infinite where it is.
std::string error_label(double error);
/// Three digits, 1.23 or 45.6 or 123; a dash if undefined.
std::string ratio_label(double ratio);
/// 10 %, 0.1 %; below as tolerance_label.
std::string accuracy_label(double accuracy);
/// 1.2e-3 and not 1.2e-03; 0 stays 0; a dash if not finite.
std::string compact_label(double x);
/// The same with one digit.
std::string digit_label(double x);
/// Per cent if that is short, from 1e-4 on; else as compact_label.
std::string share_label(double x);
/// An overlap over the smaller radius with the digits that a run prints: 5.04 %.
std::string overlap_label(double x);
/// Four digits; a dash if not finite.
std::string value_label(double x);

}  // namespace bipot

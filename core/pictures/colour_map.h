#pragma once

namespace bipot {

/// Red, green and blue in [0, 1], sRGB.
struct Colour {
  double red = 0, green = 0, blue = 0;
};

/// Colour of a number in [0, 1] (outside: the nearest end), from pale yellow over teal to dark
/// blue. A polyline in Ottosson's OKLab space with linearly decreasing lightness. Equal steps look
/// about equal, in colour and in grey.
Colour sequential_colour(double fraction);

/// Lightness L of a colour in OKLab: 0 black, 1 white.
double lightness(const Colour& colour);

}  // namespace bipot

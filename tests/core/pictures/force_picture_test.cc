#include "core/pictures/force_picture.h"

#include <cairo.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <regex>

#include "core/base/file_error.h"
#include "core/pictures/colour_map.h"
#include "core/scene/cluster_motion.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

constexpr const char* kStick = "stroke:rgb\\(2%,27%,48%\\)";
constexpr const char* kSlipRim = "stroke:rgb\\(42%,24%,0%\\)";
constexpr const char* kTakeOff = "stroke:rgb\\(55%,55%,55%\\)";

/// A column of `disks` disks of radius 1 cm on a floor, nothing touches yet.
Scene<2> column(int disks, double mu) {
  Scene<2> scene{.materials = {"stone"}, .laws = {{mu, 0, 0}}, .step = 1e-3};
  for (int k = 0; k < disks; ++k) {
    Disk d;
    d.x = Vec2(0, 0.01 + 0.02 * k);
    d.radius = 0.01;
    d.mass = d.inertia = 1;
    scene.bodies.push_back(d);
  }
  scene.walls.emplace_back();  // the half-plane y < 0
  return scene;
}

ContactOutcome<2> contact(int i, int j, double force, ContactStatus status) {
  ContactOutcome<2> c{.contact = {.i = i, .j = j, .n = Vec2(0, i < j && j < 3 ? -1 : 1), .gap = 0}};
  c.s_n = force * 1e-3;  // step 1e-3 s
  c.status = status;
  return c;
}

/// 3 N on the floor, 2 N and 1 N above; the middle one slides; one candidate carries nothing.
State<2> loaded_column(const Scene<2>& scene) {
  State<2> state = initial_state(scene);
  state.contacts = {contact(0, 1, 2, ContactStatus::kSlip), contact(0, 3, 3, ContactStatus::kStick),
                    contact(1, 2, 1, ContactStatus::kStick),
                    contact(1, 3, 0, ContactStatus::kTakeOff)};
  return state;
}

class ForcePicture : public testing::Test {
 protected:
  std::string svg(const Scene<2>& scene, const State<2>& state,
                  const std::string& caption = "caption", const ForcePictureOptions& options = {}) {
    const auto path = folder_ / "picture.svg";
    draw_force_picture(path, scene, state, caption, options);
    std::string text = file_text(path);
    EXPECT_TRUE(says(text, "</svg>"));
    EXPECT_FALSE(says(text, "nan"));
    EXPECT_FALSE(says(text, "inf"));
    return text;
  }
  /// Widths of the lines of one colour, increasing.
  static std::vector<double> widths(const std::string& svg, const std::string& colour) {
    std::vector<double> widths;
    const std::regex line("stroke-width:([0-9.e-]+);[^\"]*" + colour);
    for (std::sregex_iterator it(svg.begin(), svg.end(), line), end; it != end; ++it) {
      widths.push_back(std::stod((*it)[1]));
    }
    std::sort(widths.begin(), widths.end());
    return widths;
  }

  TemporaryFolder folder_;
};

TEST_F(ForcePicture, HasASegmentForEachContactOfAWidthInProportionToTheForce) {
  const Scene<2> scene = column(3, 0.5);
  const std::string picture = svg(scene, loaded_column(scene));
  // Stick: 1 N, 3 N (the widest, 22 points) and two samples: the force scale (2 N) and the kind
  // (6).
  const std::vector<double> stick = widths(picture, kStick);
  ASSERT_EQ(stick.size(), 4u);
  EXPECT_NEAR(stick[0], 6, 1e-5);
  EXPECT_NEAR(stick[1], 22 / 3.0, 1e-5);
  EXPECT_NEAR(stick[2], 22 * 2 / 3.0, 1e-5);
  EXPECT_NEAR(stick[3], 22, 1e-5);
  const std::vector<double> slip = widths(picture, kSlipRim);
  ASSERT_EQ(slip.size(), 2u);  // 2 N and the sample
  EXPECT_NEAR(slip[0], 6, 1e-5);
  EXPECT_NEAR(slip[1], 22 * 2 / 3.0, 1e-5);
  EXPECT_EQ(widths(picture, kTakeOff).size(), 2u);
}

TEST_F(ForcePicture, AGivenFullForceMakesPicturesComparable) {
  const Scene<2> scene = column(3, 0.5);
  const std::vector<double> stick =
      widths(svg(scene, loaded_column(scene), "", {.full_force = 6}), kStick);
  ASSERT_EQ(stick.size(), 4u);
  EXPECT_NEAR(stick[0], 22 / 6.0, 1e-5);
  EXPECT_NEAR(stick[2], 11, 1e-5);            // 3 N
  EXPECT_NEAR(stick[3], 22 * 5 / 6.0, 1e-5);  // the scale: 5 N
}

TEST_F(ForcePicture, WithoutFrictionThereIsOneKindOfLoadedContact) {
  const Scene<2> scene = column(3, 0.0);
  const std::string picture = svg(scene, loaded_column(scene));
  EXPECT_EQ(widths(picture, kStick).size(), 3u + 2u);
  EXPECT_EQ(widths(picture, kSlipRim).size(), 0u);
}

TEST_F(ForcePicture, DisksAreFilledByTheirNumberAndNoForceIsDrawnIfNoneIsWanted) {
  const Scene<2> scene = column(3, 0.5);
  ForcePictureOptions options;
  options.forces = false;
  options.fill = {.values = {0, 1, 4}, .label = "heat", .unit = "Pa", .high = 2};
  const std::string picture = svg(scene, loaded_column(scene), "", options);
  EXPECT_TRUE(widths(picture, kStick).empty());
  EXPECT_TRUE(widths(picture, kSlipRim).empty());
  EXPECT_TRUE(widths(picture, kTakeOff).empty());
  // The first, the middle and the last colour, this one also beyond the end of the bar.
  for (const double at : {0.0, 0.5, 1.0}) {
    const Colour c = sequential_colour(at);
    std::string fill = "fill:rgb\\(";
    for (double x : {c.red, c.green, c.blue}) {
      fill += fmt::format("{}[0-9.]*%,", static_cast<int>(100 * x));
    }
    fill.back() = ';';
    fill.insert(fill.size() - 1, "\\)");
    EXPECT_TRUE(std::regex_search(picture, std::regex(fill))) << fill;
  }
  options.fill.values = {1, 2};
  EXPECT_THROW(draw_force_picture(folder_ / "two.svg", scene, loaded_column(scene), "", options),
               std::invalid_argument);
  options.fill = {.values = {0, 0, 0}, .label = "heat", .unit = "Pa"};
  svg(scene, loaded_column(scene), "", options);
}

TEST_F(ForcePicture, MarkedContactsHaveARingAndAnEntryInTheLegend) {
  const Scene<2> scene = column(3, 0.5);
  const State<2> state = loaded_column(scene);
  constexpr const char* kMark = "stroke:rgb\\(80%,5%,35%\\)";
  EXPECT_TRUE(widths(svg(scene, state), kMark).empty());
  ForcePictureOptions options{.marked = {0, 2}, .marked_label = "status differs"};
  const std::string picture = svg(scene, state, "caption", options);
  EXPECT_EQ(widths(picture, kMark).size(), 3u);  // two contacts and the sample
  options.marked = {99};
  EXPECT_THROW(svg(scene, state, "caption", options), std::out_of_range);
}

TEST_F(ForcePicture, DrawsWhatThereIsWhenNothingTouches) {
  const Scene<2> one = column(1, 0.5);
  EXPECT_TRUE(widths(svg(one, initial_state(one)), kStick).empty());
  const Scene<2> three = column(3, 0.5);
  State<2> unloaded = loaded_column(three);
  for (ContactOutcome<2>& c : unloaded.contacts) c.s_n = 0;
  const std::string picture = svg(three, unloaded);
  EXPECT_TRUE(widths(picture, kStick).empty());
  EXPECT_EQ(widths(picture, kTakeOff).size(), 4u + 1u);
  Scene<2> empty = column(0, 0.5);
  svg(empty, initial_state(empty));
  empty.walls.clear();
  svg(empty, initial_state(empty));
  svg(empty, initial_state(empty), "");
}

TEST_F(ForcePicture, PngsAreWrittenWithTheChosenResolution) {
  const Scene<2> scene = column(3, 0.5);
  draw_force_picture(folder_ / "picture.png", scene, loaded_column(scene), "caption",
                     {.width = 400, .resolution = 1.5});
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> read(
      cairo_image_surface_create_from_png((folder_ / "picture.png").c_str()),
      cairo_surface_destroy);
  ASSERT_EQ(cairo_surface_status(read.get()), CAIRO_STATUS_SUCCESS);
  ASSERT_EQ(cairo_image_surface_get_width(read.get()), 600);
  const int height = cairo_image_surface_get_height(read.get());
  ASSERT_GT(height, 600);
  std::map<std::uint32_t, int> pixels;  // of each colour
  std::vector<std::uint32_t> row(600);
  for (int i = 0; i < height; ++i) {
    std::memcpy(row.data(),
                cairo_image_surface_get_data(read.get()) +
                    i * std::ptrdiff_t{cairo_image_surface_get_stride(read.get())},
                row.size() * sizeof(std::uint32_t));
    for (std::uint32_t pixel : row) ++pixels[pixel & 0xffffffu];
  }
  EXPECT_GT(pixels[0xffffff], 600 * height / 2);  // white ground
  EXPECT_GT(pixels[0x05457a], 100);               // kStick: 2, 27 and 48 hundredths
  EXPECT_EQ(pixels[0x7a4505], 0);                 // the same, red and blue exchanged
}

TEST_F(ForcePicture, ALongCaptionMakesThePictureHigher) {
  const Scene<2> scene = column(3, 0.5);
  const auto height = [&](const std::string& caption) {
    const std::string text = svg(scene, loaded_column(scene), caption);
    std::smatch match;
    EXPECT_TRUE(std::regex_search(text, match, std::regex("height=\"([0-9.]+)pt\"")));
    return std::stod(match[1]);
  };
  std::string words;
  for (int k = 0; k < 60; ++k) words += "friction ";
  EXPECT_GT(height(words), height("friction") + 60);
  EXPECT_GT(height("two\nlines"), height("two lines"));
}

TEST_F(ForcePicture, OtherFormatsAndUnwritablePlacesAreRefused) {
  const Scene<2> scene = column(3, 0.5);
  const State<2> state = loaded_column(scene);
  EXPECT_THROW(draw_force_picture(folder_ / "picture.pdf", scene, state, ""), FileError);
  EXPECT_THROW(draw_force_picture(folder_ / "no/picture.png", scene, state, ""), FileError);
  EXPECT_THROW(draw_force_picture(folder_ / "no/picture.svg", scene, state, ""), FileError);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  // A full disk is an error; what the name stands for is not removed.
  fs::create_symlink("/dev/full", folder_ / "full.png");
  EXPECT_THROW(draw_force_picture(folder_ / "full.png", scene, state, ""), FileError);
  EXPECT_TRUE(fs::exists("/dev/full"));
}

TEST(Scales, AreRoundAndNotTooLong) {
  EXPECT_DOUBLE_EQ(round_below(0.0734), 0.05);
  EXPECT_DOUBLE_EQ(round_below(0.05), 0.05);
  EXPECT_DOUBLE_EQ(round_below(4999), 2000);
  EXPECT_DOUBLE_EQ(round_below(1), 1);
  EXPECT_DOUBLE_EQ(round_below(0.999), 0.5);
  EXPECT_EQ(with_prefix(0.05, "m"), "50 mm");
  EXPECT_EQ(with_prefix(0.05, "radii"), "0.05 radii");
  EXPECT_EQ(with_prefix(1000, "N"), "1 kN");
  EXPECT_EQ(with_prefix(0.001, "m"), "1 mm");
  EXPECT_EQ(with_prefix(2, "N"), "2 N");
  EXPECT_EQ(with_prefix(0.99949, "m/s"), "999 mm/s");
  EXPECT_EQ(with_prefix(0.99951, "m/s"), "1 m/s");
  EXPECT_EQ(with_prefix(5e-6, "m"), "5 µm");
  EXPECT_EQ(with_prefix(2e15, "N"), "2e+03 TN");
  EXPECT_EQ(with_prefix(0, "N"), "0 N");
}

TEST_F(ForcePicture, JointsLeadFromTheCentreOfMassToEachDisk) {
  Scene<2> scene = column(2, 0.5);
  join_disks(scene, 2, {.mass = 1});
  EXPECT_EQ(widths(svg(scene, initial_state(scene)), "stroke:rgb\\(62%,68%,62%\\)").size(), 2u);
  EXPECT_TRUE(
      widths(svg(column(2, 0.5), initial_state(column(2, 0.5))), "stroke:rgb\\(62%,68%,62%\\)")
          .empty());
}

}  // namespace
}  // namespace bipot

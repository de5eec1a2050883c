#include "core/scene_files/scene_tables.h"

namespace bipot {

PeriodicCell read_cell(const SceneTable& root, int dim) {
  PeriodicCell cell;
  const auto table = root.table("cell");
  if (!table) return cell;
  cell.in_x = true;
  cell.width.length = table->positive("width");
  cell.in_y = dim == 2 ? table->has("height") : table->has("depth");
  if (cell.in_y) {
    cell.height.length = dim == 2 ? table->positive("height") : table->positive("depth");
  }
  if (dim == 3) return cell;
  cell.offset.length = table->number("offset", 0);
  const auto mass = table->maybe_positive("mass");

  struct Keys {
    const char* length;
    const char* speed_key;
    std::optional<double> speed;
    const char* stress_key;
    std::optional<double> stress;
  };
  const Keys sides[] = {
      {"width", "width_speed", table->maybe_number("width_speed"), "pressure_x",
       table->maybe_number("pressure_x")},
      {"height", "height_speed", table->maybe_number("height_speed"), "pressure_y",
       table->maybe_number("pressure_y")},
      {"offset", "offset_speed", table->maybe_number("offset_speed"), "shear_stress",
       table->maybe_number("shear_stress")},
  };
  bool driven = false;
  for (int k = 0; k < 3; ++k) {
    const Keys& keys = sides[k];
    CellSide& side = cell.side(k);
    if (!cell.in_y && k > 0 && (keys.speed || keys.stress || table->has(keys.length))) {
      const char* key = keys.speed ? keys.speed_key : keys.stress ? keys.stress_key : keys.length;
      table->fail(key, "needs a cell that is periodic in y as well: give its height");
    }
    if (keys.speed && keys.stress) {
      table->fail(keys.stress_key, fmt::format("the {} is moved by {} or driven by {}, not both",
                                               keys.length, keys.speed_key, keys.stress_key));
    }
    if (keys.speed) {
      side.motion = CellSide::Motion::kMoving;
      side.speed = *keys.speed;
    } else if (keys.stress) {
      if (!cell.in_y) table->fail(keys.stress_key, "needs a cell that is periodic in y as well");
      if (!mass) table->fail("mass", "is missing: what a stress drives needs one");
      driven = true;
      side.motion = CellSide::Motion::kDriven;
      side.stress = *keys.stress;
      side.mass = *mass;
    }
  }
  if (mass && !driven) table->fail("mass", "belongs to a cell that a stress drives");
  return cell;
}

}  // namespace bipot

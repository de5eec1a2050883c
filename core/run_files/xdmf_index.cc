#include "core/run_files/xdmf_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/base/types.h"
#include "core/files/atomic_file.h"
#include "core/run_files/run_layout.h"

namespace bipot {
namespace {

std::string data_item(const std::string& where, std::size_t rows, int columns, bool integer) {
  const std::string extents =
      columns == 1 ? fmt::format("{}", rows) : fmt::format("{} {}", rows, columns);
  const char* type =
      integer ? "NumberType=\"Int\" Precision=\"4\"" : "NumberType=\"Float\" Precision=\"8\"";
  return fmt::format("<DataItem Dimensions=\"{}\" {} Format=\"HDF\">{}</DataItem>", extents, type,
                     where);
}

std::string attribute(const char* name, const std::string& where, std::size_t rows,
                      const char* centre, int columns = 1, bool integer = false) {
  return fmt::format(
      "      <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">{}</Attribute>\n", name,
      columns == 1   ? "Scalar"
      : columns == 6 ? "Tensor6"
                     : "Vector",
      centre, data_item(where, rows, columns, integer));
}

std::string geometry(const std::string& where, std::size_t points, int dimensions) {
  return fmt::format("      <Geometry GeometryType=\"{}\">{}</Geometry>\n",
                     dimensions == 2 ? "XY" : "XYZ", data_item(where, points, dimensions, false));
}

/// Cells of some points each; `where`: the numbers of the points.
std::string topology(const char* type, const std::string& where, std::size_t cells, int points) {
  const std::string nodes = std::string_view(type) == "Quadrilateral"
                                ? std::string()
                                : fmt::format(" NodesPerElement=\"{}\"", points);
  return fmt::format(
      "      <Topology TopologyType=\"{}\" NumberOfElements=\"{}\"{}>{}</Topology>\n", type, cells,
      nodes, data_item(where, cells * to_size(points), 1, true));
}

/// Line segments of two points each.
std::string segments(const std::string& where, std::size_t count, int dimensions) {
  return topology("Polyline", where + "/points", count, 2) +
         geometry(where + "/segment", 2 * count, dimensions);
}

}  // namespace

void XdmfIndex::add(const Frame& frame) {
  const std::string file = "frames/" + frame_name(frame.step) + ".h5:";
  const auto grid = [&](const std::string& content) {
    return fmt::format(
        "    <Grid GridType=\"Uniform\">\n      <Time Value=\"{:.17g}\"/>\n{}    </Grid>\n",
        frame.time, content);
  };
  const int turns = has_.dimensions == 2 ? 1 : 3;  // components of spins and tangential parts
  if (has_.bodies > 0 || has_.bodies_change) {
    // Constant data lie in run.h5, unless the bodies change; no bodies are shown as one of radius
    // 0.
    const bool none = has_.bodies_change && frame.bodies == 0;
    const std::size_t n = none ? 1 : has_.bodies_change ? frame.bodies : has_.bodies;
    const std::string moving = none ? "run.h5:/no_body/" : file + frame.group;
    const std::string fixed = has_.bodies_change ? moving : "run.h5:/bodies/";
    disks_ += grid(
        topology("Polyvertex", fixed + "points", n, 1) +
        geometry(moving + (has_.cell_lines > 0 ? "x_in_cell" : "x"), n, has_.dimensions) +
        attribute("radius", fixed + "radius", n, "Node") +
        attribute("mass", fixed + "mass", n, "Node") +
        attribute("material", fixed + "material", n, "Node", 1, true) +
        (has_.clusters ? attribute("cluster", moving + "cluster", n, "Node", 1, true)
                       : std::string()) +
        attribute("velocity", moving + "v", n, "Node", 3) +
        attribute("spin", moving + "spin", n, "Node", turns) +
        (has_.dimensions == 2 ? attribute("angle", moving + "angle", n, "Node") : std::string()) +
        (frame.stress ? attribute("stress", moving + "stress", n, "Node", 6) +
                            attribute("pressure", moving + "pressure", n, "Node")
                      : std::string()));
  }
  // ParaView's readers fail on empty grids and on collections with gaps. Therefore a frame without
  // contacts shows run.h5:/no_contact, a segment of no length and no force.
  const std::size_t contacts = std::max<std::size_t>(1, frame.contacts);
  const std::string group = frame.contacts > 0 ? file + "/contacts" : "run.h5:/no_contact";
  std::string content = segments(group, contacts, has_.dimensions);
  for (const auto& [name, dataset] : {std::pair{"normal force", "force_n"},
                                      {"tangential force", "force_t"},
                                      {"normal impulse", "s_n"},
                                      {"tangential impulse", "s_t"},
                                      {"normal velocity", "u_n"},
                                      {"tangential velocity", "u_t"},
                                      {"gap", "gap"}}) {
    const bool tangential = std::string_view(dataset).ends_with("_t");
    content += attribute(name, group + "/" + dataset, contacts, "Cell", tangential ? turns : 1);
  }
  for (const auto& [name, dataset] :
       {std::pair{"status", "status"}, {"body i", "i"}, {"body j", "j"}}) {
    content += attribute(name, group + "/" + dataset, contacts, "Cell", 1, true);
  }
  if (has_.bodies > 0 || has_.bodies_change) contacts_ += grid(content);
  if (has_.walls > 0) {
    const std::string at = file + "/walls";
    walls_ += grid(has_.dimensions == 3 ? topology("Quadrilateral", at + "/points", has_.walls, 4) +
                                              geometry(at + "/piece", 4 * has_.walls, 3)
                                        : segments(at, has_.walls, 2) +
                                              attribute("material", "run.h5:/walls/material",
                                                        has_.walls, "Cell", 1, true));
  }
  if (has_.cell_lines > 0)
    cell_ += grid(segments(file + "/cell", has_.cell_lines, has_.dimensions));
  if (has_.circles > 0) {
    circles_ += grid(topology("Polyline", file + "/walls/rim_points", has_.circles, kRimPoints) +
                     geometry(file + "/walls/rim", has_.circles * to_size(kRimPoints), 2));
  }
}

void XdmfIndex::write(const std::filesystem::path& path) const {
  std::ostringstream out;
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Xdmf Version=\"2.0\">\n<Domain>\n";
  for (const auto& [name, grids] : {std::pair{"bodies", &disks_},
                                    {"contacts", &contacts_},
                                    {"walls", &walls_},
                                    {"circular walls", &circles_},
                                    {"cell", &cell_}}) {
    if (grids->empty()) continue;
    out << fmt::format("  <Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
                       name)
        << *grids << "  </Grid>\n";
  }
  out << "</Domain>\n</Xdmf>\n";
  write_text_file(path, out.str());
}

}  // namespace bipot

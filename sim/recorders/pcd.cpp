// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/pcd.hpp"

#include "sim/recorders/scan_files.hpp"

#include <string>

namespace swiftlet::sim {
namespace {

std::string pcd_header(const CloudLayout& layout) {
  const auto line = [](const char* key, const auto& value_of) {
    std::string text = key;
    for (const PointField& field : point_fields()) text += std::string(" ") + value_of(field);
    return text + "\n";
  };
  const std::string width = std::to_string(layout.width), height = std::to_string(layout.height);
  return "# .PCD v0.7 - Point Cloud Data file format\n# frame " + layout.frame + ", stamp_ns " +
         std::to_string(layout.stamp) + "\nVERSION 0.7\n" +
         line("FIELDS", [](const PointField& field) { return field.name; }) +
         line("SIZE", [](const PointField& field) { return std::to_string(field.size_bytes); }) +
         line("TYPE", [](const PointField& field) { return field.type == PointField::Type::kFloat32 ? "F" : "U"; }) +
         line("COUNT", [](const PointField&) { return "1"; }) + "WIDTH " + width + "\nHEIGHT " + height +
         "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(layout.width * layout.height) + "\nDATA binary\n";
}

}  // namespace

void PcdConfig::visit(ConfigVisitor& v) {
  visit_common(v);
  v.field("organized", organized,
          "[-] whether rows and columns of the scan are kept, with NaN for beams without return");
}

std::unique_ptr<Recorder> make_pcd_recorder(const ModuleConfig& config) {
  const auto& pcd = dynamic_cast<const PcdConfig&>(config);
  return make_scan_files_recorder(pcd, {"pcd", pcd.organized, pcd_header});
}

}  // namespace swiftlet::sim

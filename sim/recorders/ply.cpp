// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/ply.hpp"

#include "sim/recorders/scan_files.hpp"

namespace swiftlet::sim {
namespace {

const char* type_name(PointField::Type type) {
  switch (type) {
    case PointField::Type::kFloat32:
      return "float";
    case PointField::Type::kUint8:
      return "uchar";
    case PointField::Type::kUint16:
      return "ushort";
    case PointField::Type::kUint32:
      return "uint";
  }
  return "";
}

std::string ply_header(const CloudLayout& layout) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment frame " + layout.frame + "\ncomment stamp_ns " +
                       std::to_string(layout.stamp) + "\nelement vertex " +
                       std::to_string(layout.width * layout.height) + "\n";
  for (const PointField& field : point_fields()) {
    header += std::string("property ") + type_name(field.type) + " " + field.name + "\n";
  }
  return header + "end_header\n";
}

}  // namespace

void PlyConfig::visit(ConfigVisitor& v) { visit_common(v); }

std::unique_ptr<Recorder> make_ply_recorder(const ModuleConfig& config) {
  return make_scan_files_recorder(dynamic_cast<const PlyConfig&>(config), {"ply", false, ply_header});
}

}  // namespace swiftlet::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/ros_rows.hpp"

#include <limits>

namespace swiftlet::sim {
namespace {

/// Type name in ROS 1.
const char* word_of(Column::Type type) {
  switch (type) {
    case Column::Type::kTime:
      return "time";
    case Column::Type::kNumber:
      return "float64";
    case Column::Type::kInteger:
      return "int64";
    case Column::Type::kFlag:
      return "bool";
    default:
      return "string";
  }
}

/// "id_swaps" -> "IdSwaps".
std::string camel_case(std::string_view name) {
  std::string text;
  bool up = true;
  for (const char c : name) {
    if (c != '_') text.push_back(up && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c);
    up = c == '_';
  }
  return text;
}

}  // namespace

RosType row_type(std::string_view name, std::span<const Column> columns) {
  static constexpr const char* kParts[] = {"std_msgs/Header", "builtin_interfaces/Time"};
  RosType type{"swiftlet_msgs", camel_case(name), kParts, "std_msgs/Header header\n"};
  for (const Column& column : columns) type.text += std::string(word_of(column.type)) + " " + column.name + "\n";
  return type;
}

void RosRow::missing(const ColumnName&) { out_.put(std::numeric_limits<double>::quiet_NaN()); }

}  // namespace swiftlet::sim

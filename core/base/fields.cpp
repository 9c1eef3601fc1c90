// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/fields.hpp"

namespace swiftlet {
namespace {

constexpr const char* kAxes[] = {"x", "y", "z"};
constexpr const char* kPositions[] = {"x_m", "y_m", "z_m"};
constexpr const char* kRotation[] = {"qx", "qy", "qz", "qw"};
constexpr const char* kUpperTriangle[] = {"xx", "xy", "xz", "yy", "yz", "zz"};

}  // namespace

std::string ColumnName::text() const {
  const std::string_view whole = pattern;
  const std::size_t star = whole.find('*');
  std::string name(prefix);
  name += whole.substr(0, star);
  if (star == std::string_view::npos) return name;
  name += component;
  return name += whole.substr(star + 1);
}

void Columns::time(const char* name, TimeNs t, const char* doc) {
  missing_ ? sink_.missing(of(name, "", doc)) : sink_.time(of(name, "", doc), t);
}

void Columns::number(const char* name, const char* component, double value, const char* doc) {
  missing_ ? sink_.missing(of(name, component, doc)) : sink_.number(of(name, component, doc), value);
}

void Columns::integer(const char* name, std::int64_t value, const char* doc) {
  missing_ ? sink_.missing(of(name, "", doc)) : sink_.integer(of(name, "", doc), value);
}

void Columns::field(const char* name, bool value, const char* doc) {
  missing_ ? sink_.missing(of(name, "", doc)) : sink_.flag(of(name, "", doc), value);
}

void Columns::text(const char* name, std::string_view value, const char* doc) {
  missing_ ? sink_.missing(of(name, "", doc)) : sink_.text(of(name, "", doc), value);
}

void Columns::vehicle(const char* name, VehicleId id, const char* doc) {
  missing_ ? sink_.missing(of(name, "", doc)) : sink_.vehicle(of(name, "", doc), id);
}

void Columns::field(const char* name, const Vector3& value, const char* doc) {
  for (int i = 0; i < 3; ++i) number(name, kAxes[i], value[i], doc);
}

void Columns::field(const char* name, const Eigen::Quaterniond& value, const char* doc) {
  for (int i = 0; i < 4; ++i) number(name, kRotation[i], value.coeffs()[i], doc);  // Eigen stores x, y, z, w
}

void Columns::field(const char* name, const Pose& value, const char* doc) {
  for (int i = 0; i < 3; ++i) number(name, kPositions[i], value.translation()[i], doc);
  field(name, Eigen::Quaterniond(value.linear()), doc);
}

void Columns::upper_triangle(const char* name, const Matrix3& matrix, const char* doc) {
  const char* const* component = kUpperTriangle;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) number(name, *component++, matrix(i, j), doc);
  }
}

}  // namespace swiftlet

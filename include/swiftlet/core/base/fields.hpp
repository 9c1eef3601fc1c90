// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

/// Data without a format: every kind of data (a sample, a detection, a message, an event ...) is one struct whose
/// static `visit` lists each of its fields once. The state hash, tables, ROS messages, radio payloads and the reference
/// are visitors.
///
///   struct AltimeterSample {
///     static constexpr const char* kName = "altimeter";
///     TimeNs t = 0;
///     double height_m = 0.0;
///     static void visit(auto& s, auto& v) {  // const or not: one list writes and reads
///       v.time("t_s", s.t, "[s] when it was measured");
///       v.field("height_m", s.height_m, "[m] height above the surface below the vehicle");
///     }
///   };
///
/// Rules: a name ends with its unit. The text is one line, starts with the unit in brackets and names the frame. "*" is
/// replaced by the component: "v*_mps" has the columns vx_mps, vy_mps and vz_mps. "*" alone is a pose, with x_m to z_m
/// and qx to qw.
///
/// A visitor has these functions, each with the name first and the text last:
///   time        TimeNs; tables show seconds
///   field       bool, numbers, texts, vectors, quaternions, poses, bytes
///   valid       bool: when it is false, the fields that follow are meaningless
///   vehicle     VehicleId; tables show its name
///   choice      an enum; its words come before the text
///   covariance  a square matrix; tables show its first three rows and columns
///   array       numbers of which only the first few may be in use
///   list        any number of values with a `visit` of their own
namespace swiftlet {

/// Name of a value in a row; valid for the duration of the call.
struct ColumnName {
  std::string_view prefix;
  const char* pattern;    ///< with "*" in place of the component
  const char* component;  ///< "x", "xy", "qw" ...
  const char* doc;        ///< description of the whole field

  std::string text() const;
};

/// Receives the values of one row, column by column.
class ColumnSink {
 public:
  virtual ~ColumnSink() = default;
  virtual void time(const ColumnName& name, TimeNs t) = 0;
  virtual void number(const ColumnName& name, double value) = 0;
  virtual void integer(const ColumnName& name, std::int64_t value) = 0;
  virtual void flag(const ColumnName& name, bool value) = 0;
  virtual void text(const ColumnName& name, std::string_view value) = 0;
  virtual void vehicle(const ColumnName& name, VehicleId id) = 0;
  virtual void missing(const ColumnName& name) = 0;  ///< no value in this row
};

/// Visitor that flattens a kind of data into a row; all tables are made with it.
class Columns {
 public:
  /// @param prefix  prepended to every name
  explicit Columns(ColumnSink& sink, std::string_view prefix = {}) : sink_(sink), prefix_(prefix) {}

  void time(const char* name, TimeNs t, const char* doc);
  void field(const char* name, bool value, const char* doc);
  void field(const char* name, int value, const char* doc) { integer(name, value, doc); }
  void field(const char* name, std::uint16_t value, const char* doc) { integer(name, value, doc); }
  void field(const char* name, std::uint32_t value, const char* doc) { integer(name, value, doc); }
  void field(const char* name, double value, const char* doc) { number(name, "", value, doc); }
  void field(const char* name, const std::string& value, const char* doc) { text(name, value, doc); }
  void field(const char* name, const Vector3& value, const char* doc);
  void field(const char* name, const Eigen::Quaterniond& value, const char* doc);
  void field(const char* name, const Pose& value, const char* doc);
  /// Tables show only the number of bytes.
  void field(const char* name, const std::vector<std::byte>& value, const char* doc) {
    integer(name, static_cast<std::int64_t>(value.size()), doc);
  }
  void field(const char* name, const std::vector<std::uint8_t>& value, const char* doc) {
    integer(name, static_cast<std::int64_t>(value.size()), doc);
  }
  /// Tables show only the number of elements.
  template <class List>
  void list(const char* name, const List& values, const char* doc) {
    integer(name, static_cast<std::int64_t>(values.size()), doc);
  }
  void valid(const char*, bool value, const char*) { missing_ = !value; }
  void vehicle(const char* name, VehicleId id, const char* doc);
  template <class Enum>
  void choice(const char* name, Enum value, std::span<const char* const> words, const char* doc) {
    text(name, words[static_cast<std::size_t>(value)], doc);
  }
  template <class Matrix>
  void covariance(const char* name, const Matrix& matrix, const char* doc) {
    upper_triangle(name, matrix.template topLeftCorner<3, 3>(), doc);
  }

 private:
  ColumnName of(const char* name, const char* component, const char* doc) const {
    return {prefix_, name, component, doc};
  }
  void number(const char* name, const char* component, double value, const char* doc);
  void integer(const char* name, std::int64_t value, const char* doc);
  void text(const char* name, std::string_view value, const char* doc);
  void upper_triangle(const char* name, const Matrix3& matrix, const char* doc);

  ColumnSink& sink_;
  std::string_view prefix_;
  bool missing_ = false;
};

/// Puts `value` as one row.
template <class Kind>
void put_columns(const Kind& value, ColumnSink& sink, std::string_view prefix = {}) {
  Columns columns(sink, prefix);
  Kind::visit(value, columns);
}

/// Column of a table, for its header.
struct Column {
  enum class Type { kTime, kNumber, kInteger, kFlag, kText };
  std::string name;
  Type type = Type::kNumber;
  std::string doc;  ///< unit in brackets, meaning
};

/// Collects the columns that are put into it.
class ColumnList final : public ColumnSink {
 public:
  void time(const ColumnName& name, TimeNs) override { add(name, Column::Type::kTime); }
  void number(const ColumnName& name, double) override { add(name, Column::Type::kNumber); }
  void integer(const ColumnName& name, std::int64_t) override { add(name, Column::Type::kInteger); }
  void flag(const ColumnName& name, bool) override { add(name, Column::Type::kFlag); }
  void text(const ColumnName& name, std::string_view) override { add(name, Column::Type::kText); }
  void vehicle(const ColumnName& name, VehicleId) override { add(name, Column::Type::kText); }
  void missing(const ColumnName& name) override { add(name, Column::Type::kNumber); }

  const std::vector<Column>& columns() const { return columns_; }

 private:
  void add(const ColumnName& name, Column::Type type) { columns_.push_back({name.text(), type, name.doc}); }
  std::vector<Column> columns_;
};

/// The columns of a kind of data.
template <class Kind>
std::vector<Column> columns_of() {
  ColumnList list;
  put_columns(Kind{}, list);
  return list.columns();
}

}  // namespace swiftlet

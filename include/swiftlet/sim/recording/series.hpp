// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/base/fields.hpp"

namespace swiftlet::sim {

/// A table that a metric fills tick by tick. Recorders write it under its name, independent of its content.
class Series {
 public:
  explicit Series(std::string name) : name_(std::move(name)) {}
  virtual ~Series() = default;

  const std::string& name() const { return name_; }
  virtual std::vector<Column> columns() const = 0;

  /// Number of rows of this tick.
  std::size_t size() const { return about_.size(); }
  /// The vehicle that a row describes; kNoVehicle: the whole run.
  VehicleId about(std::size_t row) const { return about_[row]; }
  virtual void put(std::size_t row, ColumnSink& sink) const = 0;
  virtual void clear() { about_.clear(); }

 protected:
  std::vector<VehicleId> about_;

 private:
  std::string name_;
};

/// `Row` is a data type with fields (swiftlet/core/base/fields.hpp) and `kName`, the name of the table.
template <class Row>
class SeriesOf final : public Series {
 public:
  SeriesOf() : Series(Row::kName) {}

  void push(VehicleId about, Row row) {
    about_.push_back(about);
    rows_.push_back(std::move(row));
  }
  std::span<const Row> rows() const { return rows_; }

  std::vector<Column> columns() const override { return columns_of<Row>(); }
  void put(std::size_t row, ColumnSink& sink) const override { put_columns(rows_[row], sink); }
  void clear() override {
    Series::clear();
    rows_.clear();
  }

 private:
  std::vector<Row> rows_;
};

/// The table with rows of type `Row`; null when there is none.
template <class Row>
const SeriesOf<Row>* series_of(std::span<const Series* const> series) {
  for (const Series* table : series) {
    if (const auto* found = dynamic_cast<const SeriesOf<Row>*>(table)) return found;
  }
  return nullptr;
}

/// The rows of this tick in the table with rows of type `Row`; empty when there is no such table.
template <class Row>
std::span<const Row> rows_of(std::span<const Series* const> series) {
  const SeriesOf<Row>* const table = series_of<Row>(series);
  return table == nullptr ? std::span<const Row>() : table->rows();
}

/// Properties of a table that are known before a run.
struct TableType {
  std::string name;
  std::vector<Column> columns;
};

/// Tables of the sample types in Observation::others. Rows of the sensor registry add them.
inline std::vector<TableType>& sample_tables() {
  static std::vector<TableType> tables;
  return tables;
}

}  // namespace swiftlet::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/replay/block.hpp"
#include "swiftlet/core/base/fields.hpp"

namespace swiftlet::sim {

/// Collects values of one type, such as samples of a sensor, in a table of a replay: one row per value and one column
/// per number. Texts are omitted. Every row must have the same columns.
class Rows final : public ColumnSink {
 public:
  /// @param about  JSON object that describes the table to the replay page
  explicit Rows(std::string about) : about_(std::move(about)) {}

  /// Begins a row; the caller passes its values to the returned sink, then calls end_row().
  ColumnSink& begin_row();
  void end_row();
  /// Moves all rows to the block.
  void move_to(ReplayBlock& block);

  void time(const ColumnName& name, TimeNs t) override { put(name, to_seconds(t)); }
  void number(const ColumnName& name, double value) override { put(name, value); }
  void integer(const ColumnName& name, std::int64_t value) override { put(name, static_cast<double>(value)); }
  void flag(const ColumnName& name, bool value) override { put(name, value ? 1.0 : 0.0); }
  void text(const ColumnName&, std::string_view) override {}
  void vehicle(const ColumnName& name, VehicleId id) override { put(name, id); }
  void missing(const ColumnName& name) override;

 private:
  void put(const ColumnName& name, double value);

  std::string about_;
  std::vector<ReplayColumn> columns_;
  std::vector<double> row_;
  std::optional<ReplayTable> table_;  // created with the first row
};

}  // namespace swiftlet::sim

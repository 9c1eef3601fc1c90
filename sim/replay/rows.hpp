// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/replay/block.hpp"
#include "swiftlet/core/base/fields.hpp"

namespace swiftlet::sim {

/// Rows of any data type as a table of a replay: its numbers, by column name. Texts are omitted.
class Rows final : public ColumnSink {
 public:
  /// @param about  a JSON object
  explicit Rows(std::string about) : about_(std::move(about)) {}

  ColumnSink& begin_row();
  void end_row();
  /// Moves the rows into the block and empties the table.
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

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/replay/rows.hpp"

#include <limits>

namespace swiftlet::sim {
namespace {

/// Resolution of a column, sufficient for display.
double step_of(const std::string& name) {
  if (name.starts_with("rotor")) return 1.0;
  if (name.ends_with("qx") || name.ends_with("qy") || name.ends_with("qz") || name.ends_with("qw")) return 1e-4;
  if (name.ends_with("_m") || name.ends_with("_mps") || name.ends_with("_radps")) return 2e-3;
  return 1e-3;
}

}  // namespace

ColumnSink& Rows::begin_row() {
  row_.clear();
  return *this;
}

void Rows::put(const ColumnName& name, double value) {
  if (!table_) {
    const std::string text = name.text();
    columns_.push_back({text, step_of(text)});
  }
  row_.push_back(value);
}

void Rows::missing(const ColumnName& name) { put(name, std::numeric_limits<double>::quiet_NaN()); }

void Rows::end_row() {
  if (!table_) table_.emplace(about_, columns_);
  table_->add(row_);
}

void Rows::move_to(ReplayBlock& block) {
  if (!table_ || table_->rows() == 0) return;
  block.add(*table_);
  table_->clear();
}

}  // namespace swiftlet::sim

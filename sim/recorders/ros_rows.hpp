// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/recorders/ros_encoder.hpp"
#include "sim/recorders/ros_types.hpp"
#include "swiftlet/core/base/fields.hpp"

namespace swiftlet::sim {

/// Type of data without a ROS standard message: package swiftlet_msgs, a header, then one field per column, with the
/// column's name.
RosType row_type(std::string_view name, std::span<const Column> columns);

/// Encodes one such message: begin(), then the columns.
class RosRow final : public ColumnSink {
 public:
  RosRow(RosEncoder& out, const std::vector<std::string>& vehicle_names) : out_(out), names_(vehicle_names) {}

  void begin(std::uint32_t sequence, TimeNs stamp, std::string_view frame) {
    out_.begin();
    out_.header(sequence, stamp, frame);
  }
  void time(const ColumnName&, TimeNs t) override { out_.time(t); }
  void number(const ColumnName&, double value) override { out_.put(value); }
  void integer(const ColumnName&, std::int64_t value) override { out_.put(value); }
  void flag(const ColumnName&, bool value) override { out_.put(value); }
  void text(const ColumnName&, std::string_view value) override { out_.text(value); }
  void vehicle(const ColumnName&, VehicleId id) override {
    out_.text(id == kNoVehicle ? std::string_view() : names_[id]);
  }
  void missing(const ColumnName&) override;

 private:
  RosEncoder& out_;
  const std::vector<std::string>& names_;
};

}  // namespace swiftlet::sim

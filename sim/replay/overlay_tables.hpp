// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/replay/block.hpp"
#include "swiftlet/sim/recording/tick_view.hpp"

namespace swiftlet::sim {

/// Overlays of agents, and their maps, as tables. Each is valid until the next one of the same name and vehicle.
/// Unchanged overlays are not written again; a removed one is written as an empty table. Large ones are written at a
/// separate period.
class OverlayTables {
 public:
  /// @param map_period  period of maps and large overlays; 0: never
  explicit OverlayTables(TimeNs map_period) : map_period_(map_period) {}

  void write(const TickView& tick);
  void move_to(ReplayBlock& block);

 private:
  struct Kept {
    std::string content;
    bool seen = false;
  };

  void take(const Overlay& overlay, VehicleId vehicle, TimeNs t);

  TimeNs map_period_, next_maps_ = 0;
  bool maps_due_ = false;
  std::map<std::pair<VehicleId, std::string>, Kept> kept_;
  std::vector<ReplayTable> tables_;
};

}  // namespace swiftlet::sim

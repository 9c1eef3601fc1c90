// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/message.hpp"
#include "swiftlet/sim/radio/radio_config.hpp"
#include "swiftlet/sim/radio/radio_statistics.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Carries messages in lockstep: a message posted in one tick arrives in a later one. Each sender transmits its
/// messages one after the other, in the order of posting. A message posted at t by an idle sender starts at t, ends
/// size / rate later, and arrives after the delay. Range, line of sight and loss are decided for each receiver from the
/// vehicles' positions in the tick in which the transmission starts, at most one tick old. Jitter may change the order
/// of arrival.
class Radio {
 public:
  Radio(const RadioConfig& config, std::uint64_t seed, std::vector<std::string> vehicle_names,
        std::shared_ptr<const StaticScene> world);
  ~Radio();
  /// Accepts the messages of one vehicle; called in vehicle order. Stamps `from` and `sent`.
  void post(VehicleId from, TimeNs now, std::span<const Message> messages, std::span<const VehicleState> states);
  /// Appends the messages that reach `to` in (previous tick, now], sorted by arrival, then by sender.
  void deliver(VehicleId to, TimeNs now, std::vector<Message>& out);
  /// Reuses the memory of delivered messages and empties the list; without it every delivery allocates.
  void recycle(std::vector<Message>& messages);
  const RadioStatistics& statistics() const;
  /// Sorted by sender, then topic.
  std::vector<RadioTopicStatistics> topics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim

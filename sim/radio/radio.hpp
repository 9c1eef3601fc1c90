// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/raycast/ray_scene.hpp"
#include "sim/world/vehicle_state.hpp"
#include "swiftlet/core/config.hpp"
#include "swiftlet/core/message.hpp"

namespace swiftlet::sim {

/// One shared channel between all vehicles.
struct RadioConfig {
  double rate_kbps = 6000.0;      ///< of each sender; a message occupies it for size / rate
  double delay_s = 0.005;         ///< fixed part of the delay
  double jitter_s = 0.002;        ///< standard deviation of the random part (its absolute value is added)
  double loss_probability = 0.0;  ///< of any message to any receiver
  double range_m = 100.0;         ///< no reception beyond
  bool line_of_sight = false;     ///< does the world block it?
  double queue_limit_kB = 64.0;   ///< a sender's waiting messages beyond this are dropped, oldest first

  void visit(ConfigVisitor& v);
};

/// `sent` and `dropped` count messages, the others count pairs of message and receiver.
struct RadioStatistics {
  std::uint64_t sent = 0, delivered = 0, lost = 0, out_of_range = 0, blocked = 0, dropped = 0;
  std::uint64_t bytes_sent = 0;
  double mean_delay_s = 0.0, max_delay_s = 0.0;
};

/// Carries messages in lockstep: what is posted in a tick arrives in a later one. Each sender transmits one message
/// after the other, in the order of posting. A message posted at t while the sender is free starts at t, ends
/// size / rate later, and arrives after the delay; range, line of sight and loss are decided for each receiver with the
/// vehicles' positions in the tick in which it starts (at most one tick old). Jitter may change the order of arrival.
class Radio {
 public:
  Radio(const RadioConfig& config, std::uint64_t seed, std::vector<std::string> vehicle_names,
        std::shared_ptr<const StaticScene> world);
  ~Radio();
  /// Takes the messages of one vehicle; called in vehicle order. Stamps `from` and `sent`.
  void post(VehicleId from, TimeNs now, std::span<const Message> messages, std::span<const VehicleState> states);
  /// Appends what reaches `to` in (previous tick, now], in order of arrival, then of sender.
  void deliver(VehicleId to, TimeNs now, std::vector<Message>& out);
  /// Takes back the memory of delivered messages and empties the list; without it every delivery allocates.
  void recycle(std::vector<Message>& messages);
  const RadioStatistics& statistics() const;
  /// By sender, then topic: messages and bytes that went on the air.
  struct TopicStatistics {
    std::string topic;
    VehicleId from;
    std::uint64_t messages = 0, bytes = 0;
  };
  std::vector<TopicStatistics> topics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim

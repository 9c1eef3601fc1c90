// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// `sent` and `dropped` count messages, the others count pairs of message and receiver.
struct RadioStatistics {
  std::uint64_t sent = 0, delivered = 0, lost = 0, out_of_range = 0, blocked = 0, dropped = 0;
  std::uint64_t bytes_sent = 0;
  double mean_delay_s = 0.0, max_delay_s = 0.0;
};

/// Transmitted messages and bytes of one sender and topic.
struct RadioTopicStatistics {
  std::string topic;
  VehicleId from;
  std::uint64_t messages = 0, bytes = 0;
};

}  // namespace swiftlet::sim

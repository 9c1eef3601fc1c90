// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// What vehicles say to each other. The payload is already serialized: its size is what the radio carries.
struct Message {
  VehicleId from = kNoVehicle;
  VehicleId to = kNoVehicle;  ///< kNoVehicle: to everybody
  std::string topic;          ///< short; part of what is sent
  std::vector<std::byte> payload;
  TimeNs sent = 0;
  TimeNs received = 0;  ///< set by the radio

  std::size_t size_bytes() const { return kHeaderBytes + topic.size() + payload.size(); }
  static constexpr std::size_t kHeaderBytes = 24;  ///< from, to, stamp, lengths
};

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "core/slam/sharing/shared_maps.hpp"
#include "swiftlet/core/base/message.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"

namespace swiftlet {

/// Sends the own map, requests and closures within the data rate, in order of priority.
class MapSender {
 public:
  MapSender(const MapSharingConfig& config, VehicleId self) : config_(config), self_(self) {}

  void step(TimeNs t, OwnMap& own, std::span<PeerMap> peers, Outbox& outbox);

 private:
  bool send_next(TimeNs t, OwnMap& own, std::span<PeerMap> peers, Outbox& outbox);
  bool send_request(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const;
  bool send_cloud_request(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const;
  bool send_descriptor_request(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const;
  bool send_closures(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const;
  bool send_places(TimeNs t, OwnMap& own, Outbox& outbox);
  bool send_descriptor(OwnMap& own, Outbox& outbox) const;
  bool send_chunk(VehicleId to, const OwnMap& own, PeerMap& other, Outbox& outbox) const;

  MapSharingConfig config_;
  VehicleId self_;
  double allowance_bytes_ = 0.0;
  TimeNs last_step_ = 0;
  bool started_ = false;
  TimeNs places_sent_ = 0;
  std::size_t next_place_ = 0;
  VehicleId next_served_ = 0;
};

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/graph/closure.hpp"
#include "core/slam/graph/submap_provider.hpp"
#include "core/slam/sharing/map_sender.hpp"
#include "core/slam/sharing/shared_maps.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/message.hpp"
#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/math/latency.hpp"
#include "swiftlet/core/slam/joined_map.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"

namespace swiftlet {

/// Two vehicles exchange descriptors of their finished submaps by radio. The vehicle with the lower number requests
/// clouds of submaps similar to its own, searches them in its map and reports the closures it finds. Once enough
/// closures agree, both know the transform between their local frames. Clouds are in the frames of their submaps
/// (T_local_submap).
///
/// Messages may be lost, late, repeated or wrong: every message reports the present state, and implausible ones are
/// rejected. Results depend only on the messages, the own submaps and the times of the steps.
class MapSharing {
 public:
  MapSharing(const MapSharingConfig& config, const ClosureConfig& closures, VehicleId self, int num_vehicles);

  void step(TimeNs t, const SubmapProvider& own, std::span<const Message> messages, Outbox& outbox);

  std::span<const JoinedMap> joined_maps() const { return joined_; }
  /// Submaps of others and closures with them, in the local frame.
  void append_overlays(const SubmapProvider& own, std::vector<Overlay>& overlays) const;
  void append_counters(std::vector<Counter>& counters) const;

  int num_closures(VehicleId other) const {
    return static_cast<int>(peers_[static_cast<std::size_t>(other)].closures.size());
  }
  int num_searches() const { return num_searches_; }

 private:
  struct Search {
    VehicleId other = kNoVehicle;
    int submap = 0;  // number of the other vehicle's submap
  };
  struct Found {
    VehicleId other = kNoVehicle;
    std::optional<MapClosure> closure;
  };

  void describe_own(const SubmapProvider& own);
  void update_places(const SubmapProvider& own);
  std::optional<Search> next_search() const;
  std::vector<int> similar_submaps(const PeerSubmap& sought) const;
  void search(TimeNs t, const SubmapProvider& own);
  void take_result(TimeNs t);
  void join(TimeNs t);
  std::optional<Pose> prediction_of(const PeerMap& from, int submap) const;
  bool is_near_own(const Vector3& p_local_m) const;
  bool is_enough(const PeerMap& other) const;
  void choose_cloud(TimeNs t, PeerMap& from);

  MapSharingConfig config_;
  ClosureConfig closures_;
  VehicleId self_;
  std::vector<PeerMap> peers_;  // indexed by VehicleId; the own entry stays empty
  OwnMap own_;
  std::uint64_t places_revision_ = 0;
  bool places_known_ = false;

  Worker worker_;
  Found found_;
  ClosureCounts counts_;
  int num_searches_ = 0;
  std::uint64_t num_refused_ = 0, num_received_ = 0;
  MapSender sender_;
  std::vector<JoinedMap> joined_;
};

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/graph/submap_provider.hpp"
#include "core/slam/sharing/compact_cloud.hpp"
#include "core/slam/sharing/map_join.hpp"
#include "core/slam/sharing/submap_look.hpp"
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
  MapSharing(const MapSharingConfig& config, VehicleId self, int num_vehicles);

  void step(TimeNs t, const SubmapProvider& own, std::span<const Message> messages, Outbox& outbox);

  std::span<const JoinedMap> joined_maps() const { return joined_; }
  /// Submaps of others and closures with them, in the local frame.
  void append_overlays(const SubmapProvider& own, std::vector<Overlay>& overlays) const;
  void append_counters(std::vector<Counter>& counters) const;

  int num_closures(VehicleId other) const { return static_cast<int>(peer(other).closures.size()); }
  int num_searches() const { return num_searches_; }

 private:
  struct OwnSubmap {
    SubmapLook look;
    std::uint32_t num_points = 0;
    std::vector<PackedPoints> chunks;
    bool is_due = true;
  };
  struct PeerSubmap {
    std::optional<SubmapLook> look;
    double similarity = 0.0;  // best similarity to an own submap
    std::uint32_t num_points = 0;
    std::vector<std::uint8_t> has_chunk;
    std::vector<Eigen::Vector3f> points_submap_m;
    bool complete = false;
    bool closed = false;
    int num_searched = 0;  // number of own submaps at the last search
  };
  struct Peer {
    std::vector<SubmapPlace> places;
    std::vector<PeerSubmap> submaps;  // finished submaps that were reported
    std::uint32_t num_finished = 0;
    TimeNs last_report = 0;
    bool has_reported = false;
    // Requests to the peer.
    int fetching = -1;
    TimeNs requested = 0, descriptors_requested = 0;
    std::size_t last_requested = 0;  // number of the chunk
    bool is_requested = false;
    // Requests from the peer.
    int requested_submap = -1;
    std::vector<std::uint8_t> requested_chunks;
    // Shared results.
    std::vector<MapClosure> closures;
    bool closures_due = false;
    TimeNs closures_sent = 0;
    bool has_new_closures = false;  // since the last test of consistency
    TimeNs tested = 0;              // time of the last test of consistency
    std::vector<int> agreeing;
    std::vector<Pose> T_local_other;
  };
  struct Found {
    VehicleId other = kNoVehicle;
    std::optional<MapClosure> closure;
  };

  const Peer& peer(VehicleId other) const { return peers_[static_cast<std::size_t>(other)]; }
  bool searches_in(VehicleId other) const { return self_ < other; }
  void look_at_own(const SubmapProvider& own);
  void update_places(const SubmapProvider& own);

  bool receive(TimeNs t, const Message& message);
  bool receive_places(TimeNs t, Peer& from, const Message& message);
  bool receive_descriptor(Peer& from, const Message& message);
  bool receive_request(Peer& from, const Message& message);
  bool receive_chunk(TimeNs t, Peer& from, const Message& message);
  bool receive_closures(Peer& from, const Message& message);
  PeerSubmap& submap_of(Peer& from, std::uint32_t number);

  void search(TimeNs t, const SubmapProvider& own);
  void settle_search(TimeNs t);
  void join(TimeNs t);
  std::optional<Pose> prediction_of(const Peer& from, int submap) const;
  bool is_near_own(const Vector3& p_local_m) const;
  bool is_enough(const Peer& other) const;
  bool is_about(TimeNs t, const Peer& other) const;
  void choose_cloud(TimeNs t, Peer& from);

  void send(TimeNs t, Outbox& outbox);
  bool send_next(TimeNs t, Outbox& outbox);
  bool send_request(TimeNs t, VehicleId to, Outbox& outbox);
  bool send_closures(TimeNs t, VehicleId to, Outbox& outbox);
  bool send_places(TimeNs t, Outbox& outbox);
  bool send_descriptor(Outbox& outbox);
  bool send_chunk(VehicleId to, Outbox& outbox);

  MapSharingConfig config_;
  VehicleId self_;
  std::vector<Peer> peers_;     // indexed by VehicleId; the own entry stays empty
  std::vector<OwnSubmap> own_;  // finished submaps
  std::vector<SubmapPlace> own_places_;
  std::uint64_t places_revision_ = 0;
  bool places_known_ = false;

  Worker worker_;
  Found found_;
  int num_searches_ = 0;
  std::uint64_t num_refused_ = 0, num_received_ = 0;

  // Sending.
  double allowance_bytes_ = 0.0;
  TimeNs last_step_ = 0;
  bool started_ = false;
  TimeNs places_sent_ = 0;
  bool places_due_ = false;
  std::size_t next_place_ = 0;
  VehicleId next_served_ = 0;
  std::vector<JoinedMap> joined_;
};

}  // namespace swiftlet

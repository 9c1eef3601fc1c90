// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/slam/sharing/compact_cloud.hpp"
#include "core/slam/sharing/map_join.hpp"
#include "core/slam/sharing/submap_look.hpp"

namespace swiftlet {

/// Finished submap of the own vehicle, prepared for transmission.
struct OwnSubmap {
  SubmapLook look;
  std::uint32_t num_points = 0;
  std::vector<PackedPoints> chunks;
  bool is_due = true;  ///< its descriptor has not been sent yet
};

struct OwnMap {
  std::vector<OwnSubmap> submaps;   ///< finished submaps
  std::vector<SubmapPlace> places;  ///< poses of all submaps
  bool places_due = false;          ///< the places have changed since they were last sent
};

/// Finished submap of another vehicle. Its points are in its own frame (T_local_submap).
struct PeerSubmap {
  std::optional<SubmapLook> look;
  double similarity = 0.0;  ///< best similarity to an own submap
  std::uint32_t num_points = 0;
  std::vector<std::uint8_t> has_chunk;
  std::vector<Eigen::Vector3f> points_submap_m;
  bool complete = false;
  bool closed = false;
  int num_searched = 0;  ///< number of own submaps at the last search
};

/// Received part of the map of another vehicle, and state of the exchange with that vehicle.
struct PeerMap {
  /// True if the own vehicle searches for closures with the other: the vehicle with the lower number does so.
  bool is_searched_here = false;
  std::vector<SubmapPlace> places;
  std::vector<PeerSubmap> submaps;  ///< finished submaps that were reported
  std::uint32_t num_finished = 0;
  TimeNs last_report = 0;
  bool has_reported = false;
  // Requests to the peer.
  int fetching = -1;
  TimeNs requested = 0, descriptors_requested = 0;
  std::size_t last_requested = 0;  ///< number of the last requested chunk
  bool is_requested = false;
  // Requests from the peer.
  int requested_submap = -1;
  std::vector<std::uint8_t> requested_chunks;
  // Shared results.
  std::vector<MapClosure> closures;
  bool closures_due = false;
  TimeNs closures_sent = 0;
  bool needs_consistency_test = false;  ///< closures or submap poses have changed since the last test of consistency
  TimeNs tested = 0;                    ///< time of the last test of consistency
  std::vector<int> agreeing;
  std::vector<Pose> T_local_other;

  /// True if the vehicle has reported within the time limit.
  bool is_in_contact(TimeNs t, double timeout_s) const {
    return has_reported && to_seconds(t - last_report) <= timeout_s;
  }
};

/// [-] Reporting intervals without a message after which a vehicle counts as absent: nothing is requested from it.
/// Larger values waste requests on absent vehicles.
inline constexpr double kSilentReports = 3.0;
/// [s] Shortest interval between reports of places, and between tests of closures with one vehicle. Smaller values take
/// more of the data rate and of the time of a step.
inline constexpr double kMinUpdateInterval_s = 1.0;

/// Limits on messages. Received messages beyond them are rejected; larger limits let wrong ones take more memory.
struct MapMessageLimits {
  /// [-] Submaps of a vehicle.
  static constexpr std::uint32_t kSubmaps = 4096;
  static constexpr std::size_t kChunks = 256;      ///< chunks of a submap
  static constexpr std::uint32_t kPoints = 50000;  ///< points of a compact cloud
  static constexpr std::size_t kListed = 32;       ///< places, or closures with one vehicle, in a message
  static constexpr double kDistance_m = 1e5;       ///< distance of a submap from the start of the flight, per axis
  static constexpr double kPathLength_m = 1e6;     ///< path length of a flight
  static constexpr double kInSubmap_m = 200.0;     ///< displacement between submaps of a closure, per axis
  static constexpr double kMinTiltCosine = 0.9;    ///< least cosine of the tilt of a submap
  static constexpr double kTurnMargin_rad = 0.01;  ///< rounding of a rotation vector of length pi
  /// [m] Limits of the edge of a voxel.
  static constexpr float kMinVoxel_m = 0.01F, kMaxVoxel_m = 10.0F;
};

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Tracks from the sender's own sensors alone, and the sender's own state, in its local frame, which drifts. Received
/// tracks are never forwarded, so no data returns to its source.
struct TrackReport {
  static constexpr const char* kTopic = "track_report";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "tracks and own state of the sender, in its local frame";

  /// A track of 120 bytes. Single precision resolves a tenth of a millimeter at a kilometer.
  struct Entry {
    std::uint32_t identity = 0;
    float age_s = 0.0F;
    float existence = 0.0F;
    Eigen::Vector3f p_local_m = Eigen::Vector3f::Zero();
    Eigen::Vector3f v_local_mps = Eigen::Vector3f::Zero();
    Eigen::Matrix<float, 6, 6> covariance = Eigen::Matrix<float, 6, 6>::Identity();

    static void visit(auto& t, auto& v) {
      v.field("identity", t.identity, "[-] identity of the track at the sender");
      v.field("age_s", t.age_s, "[s] age of the track at the message's time");
      v.field("existence", t.existence, "[-] probability that the target exists");
      v.field("*_m", t.p_local_m, "[m] position in the sender's local frame");
      v.field("v*_mps", t.v_local_mps, "[m/s] velocity, in the axes of that frame");
      v.covariance("cov_*_m2", t.covariance, "[m^2] covariance of position and velocity");
    }
  };

  TimeNs t = 0;
  Vector3 p_local_m = Vector3::Zero();
  Vector3 v_local_mps = Vector3::Zero();
  double yaw_rad = 0.0;
  double yaw_rate_radps = 0.0;
  std::vector<Entry> tracks;

  static void visit(auto& m, auto& v) {
    v.time("t_s", m.t, "[s] time of validity, by the sender's clock");
    v.field("*_m", m.p_local_m, "[m] position of the sender, in its own local frame");
    v.field("v*_mps", m.v_local_mps, "[m/s] velocity of the sender, in the axes of that frame");
    v.field("yaw_rad", m.yaw_rad, "[rad] heading of the sender in that frame");
    v.field("yaw_rate_radps", m.yaw_rate_radps, "[rad/s] rate of the heading");
    v.list("num_tracks", m.tracks,
           "[-] tracks: identity, age [s], existence, position [m], velocity [m/s] and their covariance");
  }
};

}  // namespace swiftlet

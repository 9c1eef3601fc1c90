// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/base/track.hpp"

namespace swiftlet {

/// Track overlays with a color for each identity. "tracks" shows present and past positions, and the prediction for two
/// seconds. "tracks.covariance" shows ellipses of three standard deviations in the coordinate planes.
class TrackOverlays {
 public:
  /// Called after every update of the tracks.
  void push(std::span<const Track> tracks);
  void append(std::span<const Track> tracks, std::vector<Overlay>& overlays) const;

 private:
  /// Past positions of one track, in a ring buffer.
  struct Trail {
    static constexpr std::size_t kCapacity = 100;  // 10 s of a LiDAR at 10 Hz
    std::uint32_t id = 0;
    bool alive = false;
    std::size_t first = 0, count = 0;
    std::array<Eigen::Vector3f, kCapacity> points_local_m;
  };

  std::vector<Trail> trails_;
};

}  // namespace swiftlet

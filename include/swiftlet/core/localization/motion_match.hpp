// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/localization/relative_filter.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"

/// Who is who? Several vehicles with markers are seen, and nobody knows where they are. What tells them apart is how
/// they move [Zhu 2025, by trajectory matching].
namespace swiftlet {

/// How well one vehicle's odometry explains where something was seen, whatever the pose of its local frame.
struct MotionMatch {
  int count = 0;                ///< sightings of whose instants it told
  double spread_m = 0.0;        ///< RMS distance of those from their mean, in the plane
  double residual_sigma = 0.0;  ///< RMS by axis of what is left after the best alignment, in standard deviations
};
MotionMatch match_motion(std::span<const Sighting> seen, const RelativeOdometry& told, const OdometryDrift& drift,
                         double clock_s, double gap_max_s);

/// Sightings one after the other that are of one thing, because it can't have come from anywhere else.
class SightingChains {
 public:
  struct Chain {
    std::vector<Sighting> sightings;  ///< some a second, of the last seconds
    Sighting newest;
  };

  void push(const Sighting& sighting);
  /// Those that ended are forgotten.
  void forget_before(TimeNs t);
  void clear() { chains_.clear(); }
  std::span<const Chain> chains() const { return chains_; }

 private:
  std::vector<Chain> chains_;
};

}  // namespace swiftlet

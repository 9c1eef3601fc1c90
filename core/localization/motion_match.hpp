// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/localization/relative_filter.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"

/// Association of anonymous marked vehicles at unknown poses by their motion [Zhu 2025, by trajectory matching].
namespace swiftlet {

/// Agreement of one vehicle's odometry with a set of sightings, for any pose of its local frame.
struct MotionMatch {
  int count = 0;                ///< sightings with a reported odometry at their time
  double spread_m = 0.0;        ///< RMS horizontal distance of those from their mean
  double residual_sigma = 0.0;  ///< RMS residual per axis after the best alignment, in standard deviations
};
MotionMatch match_motion(std::span<const Sighting> seen, const RelativeOdometry& reported, const OdometryDrift& drift,
                         double clock_s, double gap_max_s);

/// Groups successive sightings of one object: the step between them is within a vehicle's reach.
class SightingChains {
 public:
  struct Chain {
    std::vector<Sighting> sightings;  ///< samples of the last seconds, a few per second
    Sighting newest;
  };

  void push(const Sighting& sighting);
  /// Drops chains that ended before.
  void forget_before(TimeNs t);
  void clear() { chains_.clear(); }
  std::span<const Chain> chains() const { return chains_; }

 private:
  std::vector<Chain> chains_;
};

}  // namespace swiftlet

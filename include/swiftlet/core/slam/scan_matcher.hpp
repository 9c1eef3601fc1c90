// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "swiftlet/core/slam/inertial_filter.hpp"
#include "swiftlet/core/slam/scan_to_map.hpp"

namespace swiftlet {

/// A map of one kind, and how a scan's pose is found in it. LocalSlam carries each scan to one instant, judges what is
/// found, and says when the scan goes into the map.
class ScanMatcher {
 public:
  virtual ~ScanMatcher() = default;

  /// When a scan goes into the map.
  struct Admission {
    int first_scans = 0;  ///< do in any case
    double after_m = 0.0, after_rad = 0.0, after_s = 0.0;
  };
  virtual Admission admission() const = 0;

  virtual bool is_empty() const = 0;
  virtual void clear() = 0;

  /// The scan that is matched or inserted next.
  /// @param first  it is one of the first that go into the map
  virtual void take(std::span<const Eigen::Vector3f> returns_body_m, bool first) = 0;
  /// Of it, how many are matched.
  virtual int num_points() const = 0;
  /// Of it, thinned for the map.
  virtual std::span<const Eigen::Vector3f> points_body_m() const = 0;

  struct Doubt {
    double known_share_min = 0.0;  ///< a scan of which a smaller share lies on the map moves nothing
    double smear_m = 0.0;          ///< how far points may be off because the motion was not known
    double range_sigma_m = 0.0;    ///< noise of the ranges
  };
  struct Match {
    ScanFit fit;
    int num_iterations = 0;
  };
  /// Moves the filter by what the scan says of its pose.
  virtual Match match(InertialFilter& filter, const Doubt& doubt) = 0;

  virtual void insert(const Pose& T_local_body) = 0;
  virtual std::size_t bytes() const = 0;
};

}  // namespace swiftlet

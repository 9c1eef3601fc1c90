// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "core/slam/matching/inertial_filter.hpp"
#include "core/slam/matching/scan_to_map.hpp"

namespace swiftlet {

/// Interface of scan matching to a map of its own kind. LocalSlam motion-compensates each scan, validates the match,
/// and decides when the scan is inserted.
class ScanMatcher {
 public:
  virtual ~ScanMatcher() = default;

  /// Conditions for inserting a scan into the map.
  struct Admission {
    int first_scans = 0;  ///< number of first scans that are always inserted
    double after_m = 0.0, after_rad = 0.0, after_s = 0.0;
  };
  virtual Admission admission() const = 0;

  virtual bool is_empty() const = 0;
  virtual void clear() = 0;

  /// Sets the scan for the next match or insertion.
  /// @param first  the scan is one of the first to be inserted
  virtual void take(std::span<const Eigen::Vector3f> returns_body_m, bool first) = 0;
  /// Number of points of the scan that are matched.
  virtual int num_points() const = 0;
  /// Points of the scan, thinned for the map.
  virtual std::span<const Eigen::Vector3f> points_body_m() const = 0;

  struct Uncertainty {
    double known_share_min = 0.0;  ///< smallest share of points on the map for a correction
    double smear_m = 0.0;          ///< possible displacement of points by unknown motion
    double range_sigma_m = 0.0;    ///< standard deviation of the ranges
  };
  struct Match {
    ScanFit fit;
    int num_iterations = 0;
  };
  /// Corrects the filter by the pose of the scan.
  virtual Match match(InertialFilter& filter, const Uncertainty& uncertainty) = 0;

  /// Pose of the scan, found from a poor prediction without the filter; empty if the scan meets too little of the map,
  /// or the matcher has no such search.
  /// @param width_m  of the robust kernel: how far the points may be displaced by the prediction
  virtual std::optional<Pose> align(const Pose& /*T_local_body*/, double /*width_m*/) { return std::nullopt; }

  virtual void insert(const Pose& T_local_body) = 0;
  virtual std::size_t bytes() const = 0;
};

}  // namespace swiftlet

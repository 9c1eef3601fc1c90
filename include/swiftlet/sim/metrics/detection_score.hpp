// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// Score of a detector or tracker for one target in one scan, or of one of its false estimates [Vrba 2025, eqs. 67-71].
/// NaN: not measured.
struct DetectionScore {
  static constexpr const char* kName = "scores";
  enum class Stage { kDetector, kTracker };
  TimeNs t = 0;  ///< time of validity of the estimate; without an estimate, the middle of the sweep
  Stage stage = Stage::kDetector;
  VehicleId target = kNoVehicle;  ///< kNoVehicle: a false estimate
  double distance_m = 0.0;        ///< true distance from observer to target (false estimate: to the estimate)
  int visible_points = -1;        ///< returns of the scan on the target; -1: there was no scan
  bool found = false;             ///< an estimate lies within MetricsConfig::true_positive_m
  std::uint32_t track_id = 0;
  double position_error_m = 0.0;     ///< eq. (68)
  double speed_error_mps = 0.0;      ///< eq. (69)
  double direction_error_rad = 0.0;  ///< eq. (70), only for moving targets
  double nees = 0.0;       ///< normalized estimation error squared of the position, with the reported covariance
  double latency_s = 0.0;  ///< delay from t to the current tick

  static void visit(auto& s, auto& v) {
    static constexpr const char* kStages[] = {"detector", "tracker"};
    v.time("t_s", s.t, "[s] time of validity of the estimate; for a missed target, the middle of the sweep");
    v.choice("stage", s.stage, kStages, "[-] detector or tracker");
    v.vehicle("target", s.target, "[-] empty: a false estimate");
    v.field("distance_m", s.distance_m,
            "[m] true distance from the observer to the target (false estimate: to the estimate)");
    v.field("visible_points", s.visible_points, "[-] returns of the scan on the target; -1: no scan");
    v.field("found", s.found, "[-] 1: an estimate lies within metrics.true_positive_m");
    v.field("id", s.track_id, "[-] identity of the track");
    v.field("position_error_m", s.position_error_m, "[m] error of the position [Vrba 2025, eq. 68]");
    v.field("speed_error_mps", s.speed_error_mps, "[m/s] error of the speed [eq. 69]");
    v.field("direction_error_rad", s.direction_error_rad,
            "[rad] error of the direction of motion [eq. 70], only for moving targets");
    v.field("nees", s.nees, "[-] normalized estimation error squared of the position");
    v.field("latency_s", s.latency_s, "[s] from t_s to the report");
  }
};

}  // namespace swiftlet::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "experiment.hpp"
#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/time.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

/// Flights of one vehicle on SLAM alone, evaluated against truth [Orsulic 2021]. The start pose is known, so the local
/// frame and the world coincide until a loop is closed.
namespace swiftlet::tools {

/// A sample for plots, twice a second. All positions in the world, or in the vehicle's estimate of it.
struct SlamMoment {
  double t_s = 0.0;
  Vector3 p_true_m = Vector3::Zero();
  Vector3 p_local_m = Vector3::Zero();  ///< local SLAM without corrections
  Vector3 p_shown_m = Vector3::Zero();  ///< with the part of the correction shown so far
  Vector3 p_gnss_m = Vector3::Zero();   ///< the last fix; zero: none so far
};

/// The final trajectory of the pose graph against truth.
struct GraphShape {
  double rms_m = 0.0;     ///< after the best fit of heading and displacement
  double tilt_deg = 0.0;  ///< tilt of the best rotation between graph and truth
  double climb_m = 0.0;   ///< error of the climb from first to last node
};

/// Submaps that the pose graph joined, or could have joined.
struct ClosureCount {
  int closed = 0;
  int false_ones = 0;    ///< error above kFalse_m or kFalse_deg in constrained directions
  double worst_m = 0.0;  ///< largest error of a true closure
  int revisits = 0;      ///< finished submaps that begin within kRevisit_m of a much older one
  int revisits_closed = 0;
  static constexpr double kFalse_m = 0.5, kFalse_deg = 3.0, kRevisit_m = 5.0;
};

/// Motion of the vehicle's estimated world position by corrections; goals in the frame of control move alike.
struct CorrectionCourse {
  int count = 0;
  double largest_m = 0.0;  ///< largest whole correction
  double step_m = 0.0;     ///< largest jump within one tick, at the start or end of a correction
  double speed_mps = 0.0, acceleration_mps2 = 0.0;  ///< largest at any other time
};

struct SlamFlight {
  bool crashed = false, done = false;  ///< any vehicle had a contact; the mission succeeds
  double lost_s = 0.0;                 ///< time without a valid estimate
  int warnings = 0;                    ///< number of reports that SLAM is lost or degenerate
  double time_s = 0.0, way_m = 0.0, least_clearance_m = 0.0;
  double corrected_s = -1.0;  ///< time of the first correction; -1: never
  /// Root mean square position errors: over the flight, then from the first correction on (the whole flight if there is
  /// none) of local SLAM and of the corrected estimate.
  double rms_m = 0.0, rms_local_after_m = 0.0, rms_after_m = 0.0;
  double end_m = 0.0, end_height_m = 0.0;  ///< error of the shown pose at the end of the flight
  double nees = 0.0;                       ///< mean normalized estimation error squared, 6 degrees of freedom
  double drift_10m_percent = 0.0;          ///< median over path segments of 10 m; NaN: too short
  double drift_50m_percent = 0.0;
  /// Largest true speed and acceleration from the first correction on.
  double speed_after_mps = 0.0, acceleration_after_mps2 = 0.0;
  CorrectionCourse correction;
  ClosureCount closures;
  GraphShape graph;
  std::vector<SlamMoment> moments;
  /// Occupied cells of the final map at the height kSlice_m, in the vehicle's estimate of the world; empty without a
  /// map.
  std::vector<Eigen::Vector2d> slice_world_m;
  static constexpr double kSlice_m = 2.1;
};

/// Flies the scenarios without recorders; each ends at the first contact. Closures are counted only with
/// `global: {enabled: true}`.
std::vector<SlamFlight> fly_on_slam(const Experiment& experiment, std::vector<sim::Scenario> scenarios);

/// Relative position errors over path segments of `length_m` [%], in the frame of the segment's start. Segments start
/// every `length_m` / 10.
std::vector<double> drifts_percent(const std::vector<Pose>& T_world_true, const std::vector<Pose>& T_local_estimate,
                                   double length_m);

double median_of(std::vector<double> values);  ///< ignores NaN; NaN without values

}  // namespace swiftlet::tools

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "experiment.hpp"
#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/time.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

/// Flights of one vehicle on SLAM alone, and what truth says of them [Orsulic 2021]. Its start pose was told, so that
/// its local frame and the world are the same until a loop is closed.
namespace swiftlet::tools {

/// A few times a second, for plots. All positions in the world, or in what the vehicle takes for it.
struct SlamMoment {
  double t_s = 0.0;
  Vector3 p_true_m = Vector3::Zero();
  Vector3 p_local_m = Vector3::Zero();  ///< by local SLAM alone
  Vector3 p_shown_m = Vector3::Zero();  ///< with the correction, as far as it is shown
  Vector3 p_gnss_m = Vector3::Zero();   ///< the last fix; zero: none so far
};

/// The trajectory of the pose graph in the end against truth.
struct GraphShape {
  double rms_m = 0.0;     ///< after the best heading and displacement
  double tilt_deg = 0.0;  ///< of the best attitude: how far the whole of it leans
  double climb_m = 0.0;   ///< of the height from its first node to its last, against the true one
};

/// Submaps that the pose graph joined, or could have joined.
struct ClosureCount {
  int closed = 0;
  int false_ones = 0;    ///< off by more than kFalse_m or kFalse_deg in what they tell
  double worst_m = 0.0;  ///< of the true ones
  int revisits = 0;      ///< finished submaps that began within kRevisit_m of one that was left long ago
  int revisits_closed = 0;
  static constexpr double kFalse_m = 0.5, kFalse_deg = 3.0, kRevisit_m = 5.0;
};

/// How the correction moves the vehicle's place in the world, that is goals of the world in the frame of control.
struct CorrectionCourse {
  int count = 0;
  double largest_m = 0.0;  ///< a correction, from what was shown before to what is shown in the end
  double step_m = 0.0;     ///< within one tick, when a correction begins or ends
  double speed_mps = 0.0, acceleration_mps2 = 0.0;  ///< at any other time
};

struct SlamFlight {
  bool crashed = false, done = false;  ///< somebody touched something; the mission was done
  double lost_s = 0.0;                 ///< without a valid estimate
  int warnings = 0;                    ///< how often it said that it is lost or degenerate
  double time_s = 0.0, way_m = 0.0, least_clearance_m = 0.0;
  double corrected_s = -1.0;  ///< when the first correction began to be shown; -1: never
  /// Root mean squares of the position's error; after the first correction by both, or all the time when there was
  /// none.
  double rms_m = 0.0, rms_local_after_m = 0.0, rms_after_m = 0.0;
  double end_m = 0.0, end_height_m = 0.0;  ///< what is shown against truth, when the flight ends
  double nees = 0.0;                       ///< mean of the pose's normalized squared error, 6 degrees of freedom
  double drift_10m_percent = 0.0;          ///< error of motions over 10 m of the way, median; NaN: too short
  double drift_50m_percent = 0.0;
  /// The fastest true motion from the first correction on.
  double speed_after_mps = 0.0, acceleration_after_mps2 = 0.0;
  CorrectionCourse correction;
  ClosureCount closures;
  GraphShape graph;
  std::vector<SlamMoment> moments;
  /// Occupied cells of its map around kSlice_m in the end, in what it takes for the world; no map: none.
  std::vector<Eigen::Vector2d> slice_world_m;
  static constexpr double kSlice_m = 2.1;
};

/// Flies them; they end at the first contact, and nothing is recorded. Vehicles need `global: {enabled: true}` for
/// closures to be counted.
std::vector<SlamFlight> fly_on_slam(const Experiment& experiment, std::vector<sim::Scenario> scenarios);

/// Relative errors of motions over `length_m` of the way [%]: where the vehicle would be off after so much, seen from
/// where it was. Begun every tenth of it.
std::vector<double> drifts_percent(const std::vector<Pose>& T_world_true, const std::vector<Pose>& T_local_estimate,
                                   double length_m);

double median_of(std::vector<double> values);  ///< NaN are left out; of none: NaN

}  // namespace swiftlet::tools

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "detection_log.hpp"
#include "experiment.hpp"
#include "parallel.hpp"

/// Shared by the detection experiments: flights of one observer, and their sightings by distance.
namespace swiftlet::tools {

inline constexpr double kBin_m = 5.0, kFarthestBin_m = 90.0;
inline constexpr double kIgnored_s = 10.0;  ///< start of a flight, not evaluated: rays must first clear the map
inline constexpr double kSame_m = 1.0;      ///< a track nearer than this follows the target
inline constexpr double kOs1Fov_deg = 22.5;
inline constexpr double kMid360Bottom_deg = -7.0, kMid360Top_deg = 52.0;
/// An observer's sensor, with the pose noise of detection_real [Vrba 2025, eq. 66].
inline constexpr const char* kMid360WithPose =
    "{type: lidar, name: mid360, model: mid360, mount: {position_m: [0, 0, 0.15]}, "
    "external_pose: {enabled: true, sigma_position_m: 0.05, sigma_rotation_rad: 0.005}}";
/// Upper bound of a detector's delay: it needs 0.11 s for a scan, which waits until the one before is done. A tracker
/// cannot know earlier of a target that comes into view.
inline constexpr double kTold_s = 0.3;

using Overrides = std::vector<std::pair<std::string, std::string>>;

/// A scenario of one observer and one target. The seed draws their trajectories as well.
sim::Scenario agile_flight(const std::string& name, std::uint64_t seed, double duration_s, Overrides overrides = {});

struct Flights {
  std::vector<std::unique_ptr<DetectionLog>> logs;
  /// Pooled over all flights; told_tracks counts only targets in view for kTold_s.
  std::vector<DistanceBin> detections, tracks, told_tracks;
  double observed_s = 0.0;
  int false_detections = 0, false_tracks = 0;
};
/// @param least_confidence  reports below it count neither as found nor as false
Flights fly_and_log(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios, double fov_bottom_deg,
                    double fov_top_deg, double ignored_s, double least_confidence = 0.0);

/// All bins up to a distance merged.
DistanceBin joined(const std::vector<DistanceBin>& bins, double up_to_m);

/// Bins with enough sightings, for plots; the band spans the quartiles.
struct Curve {
  std::vector<double> x_m, y, low, high;
};
Curve error_curve(const std::vector<DistanceBin>& bins);
Curve recall_curve(const std::vector<DistanceBin>& bins);
/// Expected error of a point under the noise of eq. (66), or without noise [Vrba 2025, sec. IV]: Fig. 5 applied to
/// Fig. 11.
Curve theory_curve(bool with_noise);

/// Writes every sighting to `name`-sightings.csv, to find out why targets are missed.
void write_sightings(Experiment& experiment, const std::string& name, const Flights& flights);

/// A row without published figure.
void plain_row(Experiment& experiment, const std::string& what, double value, int digits, const std::string& note = {});

}  // namespace swiftlet::tools

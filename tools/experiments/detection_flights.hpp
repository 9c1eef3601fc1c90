// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "detection_log.hpp"
#include "experiment.hpp"
#include "parallel.hpp"

/// What the detection experiments have in common: flights of one observer, and their sightings by distance.
namespace swiftlet::tools {

inline constexpr double kBin_m = 5.0, kFarthestBin_m = 90.0;
inline constexpr double kIgnored_s = 10.0;  ///< the map must first become free
inline constexpr double kSame_m = 1.0;      ///< a track nearer than this is the target's
inline constexpr double kOs1Fov_deg = 22.5;
inline constexpr double kMid360Bottom_deg = -7.0, kMid360Top_deg = 52.0;
/// An observer's sensor, with the pose noise of detection_real [Vrba 2025, eq. 66].
inline constexpr const char* kMid360WithPose =
    "{type: lidar, name: mid360, model: mid360, mount: {position_m: [0, 0, 0.15]}, "
    "external_pose: {enabled: true, sigma_position_m: 0.05, sigma_rotation_rad: 0.005}}";
/// A detector tells of a scan when it has worked on it (0.11 s), which begins when the one before is done. Only then
/// can a tracker know of a target that came into view.
inline constexpr double kTold_s = 0.3;

using Overrides = std::vector<std::pair<std::string, std::string>>;

/// A scenario of one observer and one target, whose trajectories are drawn by seed as well.
sim::Scenario agile_flight(const std::string& name, std::uint64_t seed, double duration_s, Overrides overrides = {});

struct Flights {
  std::vector<std::unique_ptr<DetectionLog>> logs;
  std::vector<DistanceBin> detections, tracks,
      told_tracks;  ///< of all flights; the last of targets in view for kTold_s
  double observed_s = 0.0;
  int false_detections = 0, false_tracks = 0;
};
/// @param least_confidence  what is told with less counts neither as found nor as false
Flights fly_and_log(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios, double fov_bottom_deg,
                    double fov_top_deg, double ignored_s, double bin_m = kBin_m, double least_confidence = 0.0);

/// All bins up to a distance in one.
DistanceBin joined(const std::vector<DistanceBin>& bins, double up_to_m);

/// Bins with enough sightings, for plots; the band is that of the quartiles.
struct Curve {
  std::vector<double> x_m, y, low, high;
};
Curve error_curve(const std::vector<DistanceBin>& bins);
Curve recall_curve(const std::vector<DistanceBin>& bins);
/// Expected error of a point under the noise of eq. (66), or none [Vrba 2025, sec. IV]: what Fig. 5 says of Fig. 11.
Curve theory_curve(bool with_noise);

/// Every single comparison, for whoever wants to know why a target was missed: `name`-sightings.csv.
void write_sightings(Experiment& experiment, const std::string& name, const Flights& flights);

/// A row without published figure.
void plain_row(Experiment& experiment, const std::string& what, double value, int digits, const std::string& note = {});

}  // namespace swiftlet::tools

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_filter_config.hpp"

namespace swiftlet {

/// Inputs of relative localization in one tick.
struct RelativeInput {
  const Observation& observation;  ///< messages
  const StateEstimate& estimate;   ///< valid
  const LocalPoses& poses;         ///< poses of the vehicle in the last seconds
  std::span<const Detection> detections = {};
  bool has_tracks = false;  ///< `tracks` was updated in this tick
  std::span<const Track> tracks = {};
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< finished in this tick, if requested
};

/// Interface of relative localization: states of teammates. A scenario selects the implementation by name.
class RelativeLocalizer {
 public:
  virtual ~RelativeLocalizer() = default;
  /// True when the implementation uses clouds itself.
  virtual bool needs_clouds() const { return false; }
  /// Appends an estimate, as of now and in the own local frame, for every teammate with known position and heading.
  virtual void step(const RelativeInput& input, std::vector<RelativeEstimate>& relatives, Outbox& outbox) = 0;
  /// Geometry for debugging in pictures; called only when a snapshot is taken.
  virtual void append_overlays(std::vector<Overlay>&) const {}
  /// Appends counters of events that exceeded the settings.
  virtual void append_counters(std::vector<Counter>&) const {}
};

/// No relative localization.
struct NoRelativeConfig : ModuleConfigOf<NoRelativeConfig> {
  void visit(ConfigVisitor&) override {}
};
std::unique_ptr<RelativeLocalizer> make_no_relative_localizer(const ModuleConfig& config, const AgentSetup& setup);

/// Relative localization of marked vehicles that report their odometry. Bright detections or tracks are aligned with
/// the reported odometry over a sliding window, and filtered [Pritzl 2024, sec. II-B]. No prior position or heading is
/// required. Several vehicles are associated by their motion.
struct SlidingWindowConfig : ModuleConfigOf<SlidingWindowConfig> {
  enum class Source { kDetections, kTracks, kMarkers };
  enum class Clock { kSynchronized, kOneWay };

  std::string other;
  std::vector<std::string> others;
  Source source = Source::kTracks;
  double marker_reflectivity = 3.0;
  double body_radius_m = 0.3;
  double center_behind_m = 0.0;
  double center_above_m = 0.0;
  Clock clock = Clock::kSynchronized;
  double clock_sigma_s = 0.005;  ///< [s] standard deviation of that clock offset, which the alignment refines; 0: exact
  double least_delay_s = 0.01;   ///< [s] with one_way: delay of the fastest message
  double odometry_gap_max_s = 2.0;  ///< [s] longest gap of the other vehicle's odometry in which sightings are paired
  double position_sigma_max_m = 1.0;
  /// [s] time with bright sightings elsewhere, but none at the expected position, after which the vehicle is lost;
  /// larger values follow a wrong estimate longer
  double reacquire_s = 3.0;
  RelativeAlignmentConfig alignment;  ///< sliding window that estimates the transform between the local frames
  RelativeFilterConfig filter;
  OdometryDriftConfig drift;

  void visit(ConfigVisitor& v) override;
};
std::unique_ptr<RelativeLocalizer> make_sliding_window_localizer(const ModuleConfig& config, const AgentSetup& setup);

/// Relative localization in a common world frame: teammates report their own position. For teams with GNSS, and, with
/// ground truth, as a reference for the cost of relative localization.
struct SharedWorldConfig : ModuleConfigOf<SharedWorldConfig> {
  std::string other;
  std::vector<std::string> others;
  double sigma_m = 0.05;
  double yaw_sigma_deg = 1.0;
  double timeout_s = 2.0;

  void visit(ConfigVisitor& v) override;
};
std::unique_ptr<RelativeLocalizer> make_shared_world_localizer(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet

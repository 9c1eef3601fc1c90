// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/counter.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_filter.hpp"

namespace swiftlet {

/// What relative localization knows in one tick.
struct RelativeInput {
  const Observation& observation;  ///< messages
  const StateEstimate& estimate;   ///< valid
  const LocalPoses& poses;         ///< where the vehicle was in the last seconds
  std::span<const Detection> detections = {};
  bool has_tracks = false;  ///< they were updated in this tick
  std::span<const Track> tracks = {};
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< new in this tick, when it needs them
};

/// Where are the other members of the team? A scenario chooses by name who answers.
class RelativeLocalizer {
 public:
  virtual ~RelativeLocalizer() = default;
  /// Does it look at clouds itself?
  virtual bool needs_clouds() const { return false; }
  /// Appends an estimate, as of now and in the own local frame, for everybody whose place and heading are known.
  virtual void step(const RelativeInput& input, std::vector<RelativeEstimate>& relatives, Outbox& outbox) = 0;
  /// What may help to understand it in a picture; called only when one is taken.
  virtual void append_overlays(std::vector<Overlay>&) const {}
  /// What did not fit its settings so far.
  virtual void append_counters(std::vector<Counter>&) const {}
};

/// Nobody is localized.
struct NoRelativeConfig : ModuleConfigOf<NoRelativeConfig> {
  void visit(ConfigVisitor&) override {}
};
std::unique_ptr<RelativeLocalizer> make_no_relative_localizer(const ModuleConfig& config, const AgentSetup& setup);

/// Vehicles with markers that tell their odometry. Bright sightings of the own detector or tracker are aligned with
/// what one tells over a sliding window, and filtered [Pritzl 2024, sec. II-B]. Nothing is known before of where it is
/// or heads. Several are told apart by how they move.
struct SlidingWindowConfig : ModuleConfigOf<SlidingWindowConfig> {
  enum class Source { kDetections, kTracks, kMarkers };
  enum class Clock { kSynchronized, kOneWay };

  std::string other;
  std::vector<std::string> others;
  Source source = Source::kTracks;
  double marker_reflectivity = 3.0;
  double body_radius_m = 0.3;
  double marker_sigma_m = 0.05;
  double marker_memory_s = 2.0;
  double center_behind_m = 0.0;
  double center_above_m = 0.0;
  Clock clock = Clock::kSynchronized;
  double clock_sigma_s = 0.005;
  double least_delay_s = 0.01;
  double odometry_gap_max_s = 2.0;
  double position_sigma_max_m = 1.0;
  double reacquire_s = 3.0;
  RelativeAlignmentConfig alignment;
  RelativeFilterConfig filter;
  OdometryDriftConfig drift;

  void visit(ConfigVisitor& v) override;
};
std::unique_ptr<RelativeLocalizer> make_sliding_window_localizer(const ModuleConfig& config, const AgentSetup& setup);

/// All vehicles know their place in one world: what another tells of itself is where it is. For teams with GNSS, and,
/// with ground truth, to see what relative localization costs.
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

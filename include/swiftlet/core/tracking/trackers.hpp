// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/tracking/cloud_tracker_config.hpp"
#include "swiftlet/core/tracking/motion_filter.hpp"
#include "swiftlet/core/tracking/tracker.hpp"

namespace swiftlet {

/// No tracking.
struct NoTrackerConfig : ModuleConfigOf<NoTrackerConfig> {
  void visit(ConfigVisitor&) override {}
};
std::unique_ptr<Tracker> make_no_tracker(const ModuleConfig& config, const AgentSetup& setup);

/// Algorithm 2 of Vrba 2025 with its Kalman filter.
struct VofodTrackerConfig : ModuleConfigOf<VofodTrackerConfig> {
  std::string sensor;  ///< name of the LiDAR; empty: the first
  CloudTrackerConfig tracker;
  KalmanConfig filter;

  void visit(ConfigVisitor& v) override;
};
std::unique_ptr<Tracker> make_vofod_tracker(const ModuleConfig& config, const AgentSetup& setup);

/// Algorithm 2 of Vrba 2025 with interacting multiple models, as used for interception (sec. VI-B).
struct ImmTrackerConfig : ModuleConfigOf<ImmTrackerConfig> {
  std::string sensor;  ///< name of the LiDAR; empty: the first
  CloudTrackerConfig tracker;
  ImmConfig filter;

  void visit(ConfigVisitor& v) override;
};
std::unique_ptr<Tracker> make_imm_tracker(const ModuleConfig& config, const AgentSetup& setup);

/// Tracks of a track-before-detect detector, as of its last finished scan; none for other detectors.
struct DetectorTracksConfig : ModuleConfigOf<DetectorTracksConfig> {
  void visit(ConfigVisitor&) override {}
};
std::unique_ptr<Tracker> make_detector_tracks(const ModuleConfig& config, const AgentSetup& setup);

/// Bypass of tracking: tracks from the mutual-localization sensor (Observation::neighbors), with the identity of the
/// vehicle + 1. A vehicle without such a sensor gets an ideal one.
struct GroundTruthTrackerConfig : ModuleConfigOf<GroundTruthTrackerConfig> {
  double range_max_m = 100.0;
  double timeout_s = 0.5;
  KalmanConfig filter;

  void visit(ConfigVisitor& v) override;
};
std::unique_ptr<Tracker> make_ground_truth_tracker(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet

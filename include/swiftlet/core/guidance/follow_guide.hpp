// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Error of the clock that stamps a vehicle's messages: a residual of synchronization, or an independent clock.
struct OwnClockConfig {
  double offset_s = 0.0;
  double drift_ppm = 0.0;

  void visit(ConfigVisitor& v);
};

/// Small periodic motion that makes the vehicle's heading observable for its guide, until the first message of the
/// guide.
struct ExcitationConfig {
  double radius_m = 0.0;
  double speed_mps = 0.5;

  void visit(ConfigVisitor& v);
};

/// The guided vehicle [Pritzl 2024, sec. II-A]. Its only sensor is odometry, which it reports to its guide. It follows
/// the waypoints that the guide sends in the vehicle's body frame, and hovers when the link times out.
struct FollowGuideConfig : ModuleConfigOf<FollowGuideConfig> {
  std::string primary;
  double odometry_rate_hz = 2.0;
  double speed_mps = 1.0;
  double visited_m = 0.3;
  double link_timeout_s = 1.5;
  ExcitationConfig excitation;
  OwnClockConfig clock;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_follow_guide(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// What the stamps of a vehicle's messages are off by: what synchronization leaves over, or a clock of its own.
struct OwnClockConfig {
  double offset_s = 0.0;
  double drift_ppm = 0.0;

  void visit(ConfigVisitor& v);
};

/// A small flight to and fro, by which the guide finds out its heading. It ends when the guide speaks.
struct ExcitationConfig {
  double radius_m = 0.0;
  double speed_mps = 0.5;

  void visit(ConfigVisitor& v);
};

/// The guided vehicle [Pritzl 2024, sec. II-A]. It knows its odometry and nothing else, and tells it to its guide. It
/// follows the waypoints that the guide tells it in its own body frame. While it hears nothing, it hovers.
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

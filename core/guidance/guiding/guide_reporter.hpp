// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/guidance/guiding/guided_path.hpp"
#include "core/guidance/guiding/guided_team.hpp"

namespace swiftlet {

/// Messages to the guided vehicles: to the moving one the rest of its path, to all others an empty path, on which they
/// hover.
class GuideReporter {
 public:
  /// @param config  must outlive this object
  explicit GuideReporter(const GuideConfig& config) : config_(config) {}

  /// Marks the path as new, so that it is sent even if paths are not sent periodically.
  void start_path() { was_path_sent_ = false; }
  /// Sends the messages that are due.
  void send(const GuidanceInput& input, const GuidedTeam& team, const GuidedPath& path, MissionStatus mission,
            Outbox& outbox);

 private:
  void send_to(const GuidedVehicle& vehicle, const GuidanceInput& input, const GuidedTeam& team, const GuidedPath& path,
               MissionStatus mission, Outbox& outbox);

  const GuideConfig& config_;
  TimeNs next_ = 0;
  std::uint32_t num_sent_ = 0;
  bool was_path_sent_ = false;
};

}  // namespace swiftlet

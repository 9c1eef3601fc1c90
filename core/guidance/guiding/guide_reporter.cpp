// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/guiding/guide_reporter.hpp"

#include <algorithm>

#include "core/guidance/guiding/guide_constants.hpp"
#include "swiftlet/core/messages/kind.hpp"

namespace swiftlet {

void GuideReporter::send(const GuidanceInput& input, const GuidedTeam& team, const GuidedPath& path,
                         MissionStatus mission, Outbox& outbox) {
  const TimeNs now = input.observation.t;
  if (now < next_ || std::ranges::none_of(team.vehicles(), &GuidedVehicle::was_known)) return;
  next_ = now + from_seconds(GuideConstants::kGuidingPeriod_s);
  ++num_sent_;
  for (const GuidedVehicle& vehicle : team.vehicles()) {
    if (vehicle.was_known) send_to(vehicle, input, team, path, mission, outbox);
  }
}

void GuideReporter::send_to(const GuidedVehicle& vehicle, const GuidanceInput& input, const GuidedTeam& team,
                            const GuidedPath& path, MissionStatus mission, Outbox& outbox) {
  using Command = GuidingPath::Command;
  GuidingPath report;
  report.path = num_sent_;
  if (vehicle.id == team.moving().id) {
    const bool guides = !path.empty() && vehicle.ready();
    if (guides && !config_.periodic && was_path_sent_) return;
    if (guides) {
      const double range_m = GuideConstants::kSightFactor * config_.planner.viewpoint.ray_max_m;
      const std::size_t num_poses =
          config_.motion == GuideConfig::Motion::kTogether
              ? path.num_in_sight(*input.map, input.estimate.T_local_body.translation(), range_m)
              : path.poses().size();
      path.append_to(report, num_poses, *vehicle.estimate);
    }
    was_path_sent_ = guides;
    report.radius_m = team.figure_m();
  }
  report.command = mission == MissionStatus::kDone     ? Command::kDone
                   : mission == MissionStatus::kFailed ? Command::kFailed
                   : report.radius_m > 0.0             ? Command::kMove
                                                       : Command::kGuide;
  write_message(report, outbox.add(vehicle.id));
}

}  // namespace swiftlet

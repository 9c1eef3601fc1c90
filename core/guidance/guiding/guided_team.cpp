// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/guiding/guided_team.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/guidance/guiding/guide_constants.hpp"
#include "swiftlet/core/base/vehicle_named.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {

GuidedTeam::GuidedTeam(const GuideConfig& config, const AgentSetup& setup) : config_(config) {
  const auto add = [&](const std::string& name, const char* key, const auto& goals_m, const auto& goal_yaws_deg) {
    GuidedVehicle vehicle;
    vehicle.id = vehicle_named(name, setup, key);
    vehicle.goals_world_m = goals_m;
    vehicle.goal_yaws_deg = goal_yaws_deg;
    const bool twice = std::ranges::any_of(vehicles_, [&](const auto& other) { return other.id == vehicle.id; });
    if (twice) throw std::invalid_argument(std::string(key) + ": expected each vehicle once, found it twice");
    vehicles_.push_back(std::move(vehicle));
  };
  if (config.secondaries.empty()) {
    add(config.secondary, "guidance.secondary", config.goals_m, config.goal_yaws_deg);
  }
  for (const GuidedVehicleConfig& one : config.secondaries) {
    add(one.name, "guidance.secondaries.name", one.goals_m, one.goal_yaws_deg);
  }
}

void GuidedTeam::update(const GuidanceInput& input) {
  const TimeNs now = input.observation.t;
  for (GuidedVehicle& vehicle : vehicles_) {
    std::optional<RelativeEstimate>& estimate = vehicle.estimate;
    estimate.reset();
    for (const RelativeEstimate& relative : input.relatives) {
      if (relative.other == vehicle.id) estimate = relative;
    }
    vehicle.known_well =
        estimate && std::sqrt(estimate->covariance.topLeftCorner<3, 3>().diagonal().maxCoeff()) < config_.sigma_max_m;
    vehicle.linked = estimate && now - estimate->report_t < from_seconds(config_.link_timeout_s);
    vehicle.was_known = vehicle.was_known || vehicle.ready();
    if (!estimate) continue;
    vehicle.last_place_local_m = estimate->position_m;
    vehicle.last_known = now;
  }
  // The heading of a hovering vehicle is not observable. Without an estimate, the moving vehicle flies a
  // figure, as before it was first found.
  const GuidedVehicle& lost = moving();
  const bool searches =
      !lost.estimate && lost.was_known && now - lost.last_known >= from_seconds(GuideConstants::kSearchAfter_s);
  const double room_m = searches ? room_for_figure_m(input) : 0.0;
  figure_m_ = room_m >= GuideConstants::kFigureMin_m ? room_m : 0.0;
}

double GuidedTeam::room_for_figure_m(const GuidanceInput& input) const {
  const Vector3& place_local_m = moving().last_place_local_m;
  double room_m = input.map->distance_m(place_local_m, 2.0) - GuideConstants::kFigureClearance_m;
  for (const Vector3& p_local_m : hovering_local_m()) {
    const double between_m = (p_local_m - place_local_m).head<2>().norm();
    room_m = std::min(room_m, between_m - 2.0 * GuideConstants::kFigureClearance_m);
  }
  return room_m;
}

std::vector<Vector3> GuidedTeam::hovering_local_m() const {
  std::vector<Vector3> places_local_m;
  places_local_m.reserve(vehicles_.size());
  for (const GuidedVehicle& vehicle : vehicles_) {
    if (vehicle.id != moving().id) places_local_m.push_back(vehicle.last_place_local_m);
  }
  return places_local_m;
}

bool GuidedTeam::all_ready() const { return std::ranges::all_of(vehicles_, &GuidedVehicle::ready); }
bool GuidedTeam::all_were_known() const { return std::ranges::all_of(vehicles_, &GuidedVehicle::was_known); }

bool GuidedTeam::has_more_goals(const GuidedVehicle& vehicle) const {
  if (advances()) return vehicle.advanced_m < config_.advance.distance_m;
  return config_.loop || vehicle.num_reached < vehicle.goals_world_m.size();
}

bool GuidedTeam::has_more_goals() const {
  return std::ranges::any_of(vehicles_, [this](const GuidedVehicle& vehicle) { return has_more_goals(vehicle); });
}

bool GuidedTeam::has_goal_after(const Vector3& goal_local_m) const {
  if (advances()) return (goal_local_m - *moving().began_local_m).head<2>().norm() < config_.advance.distance_m;
  return config_.loop || moving().num_reached + 1 < moving().goals_world_m.size();
}

bool GuidedTeam::choose_next() {
  for (std::size_t i = 1; i <= vehicles_.size(); ++i) {
    const std::size_t next = (moving_ + i) % vehicles_.size();
    if (!has_more_goals(vehicles_[next]) || !vehicles_[next].estimate) continue;
    moving_ = next;
    return true;
  }
  return false;
}

PlannedPose GuidedTeam::take_goal(const FrameChange& to_local) {
  GuidedVehicle& vehicle = vehicles_[moving_];
  if (!vehicle.began_local_m) vehicle.began_local_m = there().position_m;
  return goal_from(pose(), vehicle.num_reached, to_local);
}

PlannedPose GuidedTeam::goal_from(const PlannedPose& from, std::size_t num_reached, const FrameChange& to_local) const {
  PlannedPose goal = from;
  if (advances()) {
    const Vector3 step_local_m = to_local.direction(config_.advance.step_m);
    goal.p_local_m += step_local_m;
    goal.p_local_m.z() = moving().began_local_m->z() + step_local_m.z();
    return goal;
  }
  const std::size_t i = num_reached % moving().goals_world_m.size();
  goal.p_local_m = to_local.point(moving().goals_world_m[i]);
  if (i < moving().goal_yaws_deg.size()) goal.yaw_rad = to_local.yaw(moving().goal_yaws_deg[i] * kRadPerDeg);
  return goal;
}

void GuidedTeam::reach() {
  GuidedVehicle& vehicle = vehicles_[moving_];
  ++vehicle.num_reached;
  if (!vehicle.began_local_m || !vehicle.estimate) return;
  vehicle.advanced_m = (vehicle.estimate->position_m - *vehicle.began_local_m).head<2>().norm();
}

}  // namespace swiftlet

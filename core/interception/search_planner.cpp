// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/search_planner.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

struct SearchTuning {
  double update_period_s = 0.2;  ///< [s] period of updates of the particles, which cost most of a search
  double goal_period_s = 1.0;    ///< [s] period of new goals; shorter periods make the vehicle turn more often
  double lost_sigma_m = 0.5;     ///< [m] least standard deviation of the position of a target that was just lost
  double lost_sigma_mps = 1.0;   ///< [m/s] standard deviation of its velocity
  double reported_sigma_m = 0.5, reported_sigma_mps = 1.0;  ///< [m, m/s] the same of a target that a teammate reports
};
constexpr SearchTuning kSearch;

}  // namespace

void SearchPlanner::begin(const TargetPrediction& lost, double timeout_s, const Vector3& own_local_m) {
  search_.begin(lost.at(0.0), std::max(kSearch.lost_sigma_m, lost.sigma_m(0.0)), kSearch.lost_sigma_mps);
  since_update_s_ = since_goal_s_ = 0.0;
  goal_local_m_ = lost.at(timeout_s).p_m;
  highest_m_ = search_.highest_near_m(own_local_m);
}

void SearchPlanner::begin(const Teammate& teammate, TimeNs now, const Vector3& own_local_m) {
  since_update_s_ = since_goal_s_ = 0.0;
  restart(teammate, now, own_local_m);
}

void SearchPlanner::restart(const Teammate& teammate, TimeNs now, const Vector3& own_local_m) {
  const PointState reported = teammate.target_at(now);
  search_.begin(reported, kSearch.reported_sigma_m, kSearch.reported_sigma_mps);
  goal_local_m_ = reported.p_m;
  highest_m_ = search_.highest_near_m(own_local_m);
}

bool SearchPlanner::tick(double dt_s) {
  since_update_s_ += dt_s;
  since_goal_s_ += dt_s;
  return since_update_s_ >= kSearch.update_period_s;
}

void SearchPlanner::update(const Teammate* teammate, TimeNs now, const Vector3& own_local_m,
                           const Surroundings& surroundings) {
  if (teammate != nullptr) restart(*teammate, now, own_local_m);
  search_.advance(since_update_s_, surroundings.fence);
  search_.look(own_local_m, since_update_s_, surroundings.map);
  since_update_s_ = 0.0;
  highest_m_ = search_.highest_near_m(own_local_m);
  if (since_goal_s_ < kSearch.goal_period_s) return;
  since_goal_s_ = 0.0;
  goal_local_m_ = search_.most_probable();
}

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/search_planner.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

struct SearchTuning {
  double update_period_s = 0.2;  ///< [s] period of updates of the particles, which cost most of a search
  double goal_period_s = 1.0;    ///< [s] period of new goals; shorter periods make the vehicle turn more often
  double sigma_m = 0.5;          ///< [m] standard deviation of a reported position, least one of a lost target's
  double sigma_mps = 1.0;        ///< [m/s] standard deviation of the target's velocity
};
constexpr SearchTuning kSearch;

}  // namespace

void SearchPlanner::begin(const TargetPrediction& lost) {
  since_update_s_ = since_goal_s_ = 0.0;
  restart(lost.at(0.0), std::max(kSearch.sigma_m, lost.sigma_m(0.0)));
}

void SearchPlanner::begin(const Teammate& teammate, TimeNs now) {
  since_update_s_ = since_goal_s_ = 0.0;
  restart(teammate.target_at(now), kSearch.sigma_m);
}

void SearchPlanner::restart(const PointState& target, double sigma_m) {
  search_.begin(target, sigma_m, kSearch.sigma_mps);
  goal_local_m_ = target.p_m;
}

bool SearchPlanner::tick(double dt_s) {
  since_update_s_ += dt_s;
  since_goal_s_ += dt_s;
  return since_update_s_ >= kSearch.update_period_s;
}

void SearchPlanner::update(const Teammate* teammate, TimeNs now, const Vector3& own_local_m,
                           const Surroundings& surroundings) {
  if (teammate != nullptr) restart(teammate->target_at(now), kSearch.sigma_m);
  search_.advance(since_update_s_, surroundings.fence);
  search_.look(own_local_m, since_update_s_, surroundings.map);
  since_update_s_ = 0.0;
  if (since_goal_s_ < kSearch.goal_period_s) return;
  since_goal_s_ = 0.0;
  goal_local_m_ = search_.most_probable();
}

}  // namespace swiftlet

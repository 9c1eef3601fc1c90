// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/guiding/leg_planner.hpp"

#include <utility>

namespace swiftlet {

void LegPlanner::start(const GuidanceInput& input, const PlannedPose& from, const PlannedPose& goal,
                       const TeamTraffic& traffic) {
  plan_ = plan_leg(input, from, goal, traffic);
  worker_.start(input.observation.t);
}

void LegPlanner::start_next(const GuidanceInput& input, const PlannedPose& goal, double yaw_rad,
                            const TeamTraffic& traffic) {
  TeamPlan next = plan_leg(input, {plan_->goal_local_m, yaw_rad}, goal, traffic);
  if (next.next != TeamPlan::Next::kMovePrimary && next.next != TeamPlan::Next::kMoveSecondary) return;
  next_ = std::move(next);
  worker_.start(input.observation.t);
}

void LegPlanner::take_next() {
  plan_ = std::move(next_);
  next_.reset();
}

TeamPlan LegPlanner::plan_leg(const GuidanceInput& input, const PlannedPose& from, const PlannedPose& goal,
                              const TeamTraffic& traffic) {
  TeamPlan plan = plan_team(*input.map, config_, input.estimate.T_local_body.translation(), from, goal, traffic);
  ++num_plans_;
  if (plan.primary_search == ClearPathStatus::kBudgetSpent) ++num_given_up_primary_;
  if (plan.secondary_search == ClearPathStatus::kBudgetSpent) ++num_given_up_secondary_;
  return plan;
}

void LegPlanner::append_counters(std::vector<Counter>& counters) const {
  const char* what = "path searches that ended at their budget";
  counters.push_back({what, num_given_up_primary_, num_plans_, "planner.primary.max_expansions"});
  counters.push_back({what, num_given_up_secondary_, num_plans_, "planner.secondary.max_expansions"});
}

}  // namespace swiftlet

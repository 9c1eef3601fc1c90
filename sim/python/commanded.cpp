// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/commanded.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"

namespace swiftlet::python {
namespace {

using Row = std::array<double, kMaxRotors>;

// Largest lead of a goal over its vehicle, so that commands that the vehicle cannot follow do not accumulate.
constexpr double kMaxLead_m = 0.5;
constexpr double kMaxLead_s = 0.5;

constexpr int kGoalNumbers = 4;  // velocity and yaw rate, or position and yaw

struct CommandedConfig : ModuleConfigOf<CommandedConfig> {
  enum class By { kVelocity, kPosition };
  By by = By::kVelocity;
  std::shared_ptr<const Commands> commands;

  void visit(ConfigVisitor& v) override {
    v.choice("by", by, {"velocity", "position"},
             "[-] a row of commands: vx, vy, vz [m/s], yaw rate [rad/s]; or x, y, z [m], yaw [rad]; world");
  }
};

struct RotorsConfig : ModuleConfigOf<RotorsConfig> {
  std::shared_ptr<const Commands> commands;
  void visit(ConfigVisitor&) override {}
};

void require_finite(const Row& row, int count, const AgentSetup& setup) {
  for (int i = 0; i < count; ++i) {
    if (!std::isfinite(row[i]))
      throw std::invalid_argument("commands of " + setup.vehicle_names[setup.self] +
                                  ": expected finite numbers, found " + std::to_string(row[i]));
  }
}

class Commanded final : public Guidance {
 public:
  Commanded(const CommandedConfig& config, const AgentSetup& setup) : config_(config), setup_(setup) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    if (!started_) {
      goal_world_.position_m = input.estimate.T_world_body().translation();
      goal_world_.yaw_rad = yaw_of(input.estimate.T_world_body().linear());
      started_ = true;
    }
    if (config_.commands != nullptr) take((*config_.commands)[setup_.self], input);
    output.goal = FrameChange::to_local(input.estimate).reference(goal_world_);
    output.mission = MissionStatus::kEndless;
  }

 private:
  void take(const Row& row, const GuidanceInput& input) {
    if (config_.by == CommandedConfig::By::kPosition) {
      if (std::isnan(row[0])) return;  // no command so far
      require_finite(row, kGoalNumbers, setup_);
      goal_world_.position_m = {row[0], row[1], row[2]};
      goal_world_.yaw_rad = row[3];
      return;
    }
    require_finite(row, kGoalNumbers, setup_);
    const Vector3 v_world_mps(row[0], row[1], row[2]);
    const Vector3 p_world_m = input.estimate.T_world_body().translation();
    Vector3 ahead_m = goal_world_.position_m + input.dt_s * v_world_mps - p_world_m;
    const double reach_m = kMaxLead_m + kMaxLead_s * v_world_mps.norm();
    if (ahead_m.norm() > reach_m) ahead_m *= reach_m / ahead_m.norm();
    goal_world_.position_m = p_world_m + ahead_m;
    goal_world_.velocity_mps = v_world_mps;
    goal_world_.yaw_rad += input.dt_s * row[3];
    goal_world_.yaw_rate_radps = row[3];
  }

  CommandedConfig config_;
  AgentSetup setup_;
  Reference goal_world_;
  bool started_ = false;
};

/// Agent without controller: passes rotor commands through.
class Rotors final : public Agent {
 public:
  Rotors(const RotorsConfig& config, const AgentSetup& setup) : config_(config), setup_(setup) {
    action_.mission = MissionStatus::kEndless;
  }

  const Action& step(const Observation& observation) override {
    action_.clear_outputs();
    if (config_.commands == nullptr) return action_;
    const Row& row = (*config_.commands)[setup_.self];
    const int num_rotors = setup_.airframe.num_rotors();
    require_finite(row, num_rotors, setup_);
    for (int i = 0; i < num_rotors; ++i) action_.rotor_command[i] = row[i];
    if (observation.pose.empty()) return action_;
    const PoseSample& pose = observation.pose.back();
    action_.estimate.t = pose.t;
    action_.estimate.valid = true;
    action_.estimate.T_local_body = pose.T_world_body;
    action_.estimate.v_local_mps = pose.v_world_mps;
    action_.reference.position_m = pose.T_world_body.translation();
    return action_;
  }

 private:
  RotorsConfig config_;
  AgentSetup setup_;
  Action action_;
};

std::unique_ptr<Guidance> make_commanded(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Commanded>(dynamic_cast<const CommandedConfig&>(config), setup.agent);
}

std::unique_ptr<Agent> make_rotors(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<Rotors>(dynamic_cast<const RotorsConfig&>(config), setup);
}

AgentNeeds rotors_needs(const ModuleConfig&) {
  AgentNeeds needs;
  needs.true_pose = true;
  return needs;
}

}  // namespace

void add_commanded_modules() {
  guidance_registry().add(
      {{"commanded", "flies commands from Python", make_module_config<CommandedConfig>}, make_commanded});
  agent_registry().add(
      {{"rotors", "rotor commands come from Python", make_module_config<RotorsConfig>}, make_rotors, rotors_needs});
}

int num_commands(const sim::Scenario& scenario) {
  int most = kGoalNumbers;
  for (const sim::VehicleConfig& vehicle : scenario.vehicles) {
    if (dynamic_cast<const RotorsConfig*>(vehicle.agent.config.get()) != nullptr)
      most = std::max(most, vehicle.airframe.num_rotors());
  }
  return most;
}

void connect_commands(sim::Scenario& scenario, const std::shared_ptr<Commands>& commands) {
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    Module& agent = scenario.vehicles[i].agent;
    if (auto* rotors = dynamic_cast<RotorsConfig*>(agent.config.get())) rotors->commands = commands;
    Module* guidance = guidance_of(agent);
    auto* commanded = guidance == nullptr ? nullptr : dynamic_cast<CommandedConfig*>(guidance->config.get());
    if (commanded == nullptr) continue;
    commanded->commands = commands;
    if (commanded->by == CommandedConfig::By::kPosition) (*commands)[i].fill(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace swiftlet::python

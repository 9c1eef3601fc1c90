// SPDX-License-Identifier: BSD-3-Clause
// A custom agent: all the software of a vehicle in one class. This one holds a position with two cascaded loops,
// position to thrust and attitude to torque.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/control/mixer.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace {

using namespace swiftlet;

struct KeeperConfig : ModuleConfigOf<KeeperConfig> {
  Eigen::Vector3d place_m = {0.0, 0.0, 3.0};
  double position_radps = 1.5;
  double attitude_radps = 8.0;

  void visit(ConfigVisitor& v) override {
    v.field("place_m", place_m, "[m] position to hold, world");
    v.field("position_radps", position_radps, "[rad/s] natural frequency of the position loop", Range::positive());
    v.field("attitude_radps", attitude_radps, "[rad/s] natural frequency of the attitude loop", Range::positive());
  }
};

class Keeper : public Agent {
 public:
  Keeper(const KeeperConfig& config, const AgentSetup& setup)
      : config_(config), airframe_(setup.airframe), mixer_(setup.airframe) {
    action_.mission = MissionStatus::kEndless;
  }

  /// The inputs of an agent are its setup and its observations. The returned action holds until the next step.
  const Action& step(const Observation& observation) override {
    action_.clear_outputs();
    if (observation.pose.empty()) return action_;
    const PoseSample& pose = observation.pose.back();
    publish_estimate(pose);
    command_rotors(mixer_.forces(wrench_for(pose)));
    return action_;
  }

 private:
  Wrench wrench_for(const PoseSample& pose) const {
    const Matrix3 R_world_body = pose.T_world_body.linear();
    const double k = config_.position_radps, a = config_.attitude_radps;
    const Vector3 error_m = config_.place_m - pose.T_world_body.translation();
    const Vector3 thrust_mps2 = k * k * error_m - 2.0 * k * pose.v_world_mps + 9.81 * Vector3::UnitZ();
    // Small-angle rotation of the body's z axis to the desired thrust.
    const Vector3 tilt_body = R_world_body.transpose() * R_world_body.col(2).cross(thrust_mps2.normalized());
    const Vector3 turn_radps2 = a * a * tilt_body - 2.0 * a * pose.omega_body_radps;
    return {airframe_.mass_kg * thrust_mps2.dot(R_world_body.col(2)),
            airframe_.inertia_diagonal_kgm2.cwiseProduct(turn_radps2)};
  }

  /// A command is the rotor's speed, from 0 (least) to 1 (greatest).
  void command_rotors(const Mixer::Forces& force_N) {
    const double least = airframe_.rotor_speed_min_radps, greatest = airframe_.rotor_speed_max_radps;
    for (int i = 0; i < airframe_.num_rotors(); ++i) {
      const double speed_radps = std::sqrt(std::max(0.0, force_N[i]) / airframe_.thrust_constant_N_per_radps2);
      action_.rotor_command[i] = std::clamp((speed_radps - least) / (greatest - least), 0.0, 1.0);
    }
  }

  /// For metrics and recorders only; control does not use it.
  void publish_estimate(const PoseSample& pose) {
    action_.estimate.t = pose.t;
    action_.estimate.valid = true;
    action_.estimate.T_local_body = pose.T_world_body;
    action_.estimate.v_local_mps = pose.v_world_mps;
    action_.reference.position_m = config_.place_m;
  }

  KeeperConfig config_;
  Airframe airframe_;
  Mixer mixer_;
  Action action_;
};

std::unique_ptr<Agent> make_keeper(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<Keeper>(dynamic_cast<const KeeperConfig&>(config), setup);
}

/// The simulator adds an ideal `pose` sensor to vehicles that carry none.
AgentNeeds keeper_needs(const ModuleConfig&) {
  AgentNeeds needs;
  needs.true_pose = true;
  return needs;
}

}  // namespace

int main() {
  agent_registry().add({{"keeper", "holds a position", make_module_config<KeeperConfig>}, make_keeper, keeper_needs});

  sim::Scenario scenario;
  scenario.duration_s = 10.0;
  scenario.world = Module(sim::world_module_types(), "empty");
  scenario.wind.mean_mps = {1.0, 0.0, 0.0};
  scenario.vehicles[0].start.position_m = {2.0, -1.0, 2.0};
  scenario.vehicles[0].agent = Module(agent_module_types(), "keeper");

  sim::Simulation simulation(scenario);
  while (!simulation.finished()) simulation.tick();
  const Vector3 error_m = simulation.view().states[0].p_world_m - Vector3(0.0, 0.0, 3.0);
  std::printf("keeper: %.3f m from its place after %.0f s in a breeze\n", error_m.norm(), scenario.duration_s);
  return error_m.norm() < 0.2 ? 0 : 1;
}

// External robot program that uses Swiftlet's core alone.
#include <cstdio>

#include "swiftlet/core/agent/registry.hpp"

int main() {
  swiftlet::AgentSetup setup;
  setup.airframe.rotors = {{{0.18, 0.18, 0.0}, swiftlet::Rotor::Spin::kCw},
                           {{-0.18, 0.18, 0.0}, swiftlet::Rotor::Spin::kCcw},
                           {{-0.18, -0.18, 0.0}, swiftlet::Rotor::Spin::kCw},
                           {{0.18, -0.18, 0.0}, swiftlet::Rotor::Spin::kCcw}};
  const auto agent = swiftlet::make_agent(swiftlet::Module(swiftlet::agent_module_types(), "stack"), setup);
  swiftlet::Observation observation;
  observation.t = 4'000'000;
  observation.pose.push_back(
      {observation.t, swiftlet::Pose::Identity(), swiftlet::Vector3::Zero(), swiftlet::Vector3::Zero()});
  const swiftlet::Action& action = agent->step(observation);
  std::printf("first rotor command: %.3f\n", action.rotor_command[0]);
  return action.rotor_command[0] >= 0.0 ? 0 : 1;
}

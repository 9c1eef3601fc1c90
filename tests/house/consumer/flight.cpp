// External program that runs Swiftlet's simulation.
#include <cstdio>

#include "swiftlet/sim/run/simulation.hpp"

int main() {
  swiftlet::sim::Scenario scenario;
  scenario.duration_s = 0.2;
  swiftlet::sim::Simulation simulation(scenario);
  while (!simulation.finished()) simulation.tick();
  std::printf("state hash after %.1f s: %016llx\n", swiftlet::to_seconds(simulation.now()),
              static_cast<unsigned long long>(simulation.state_hash()));
  return simulation.state_hash() != 0 ? 0 : 1;
}

// SPDX-License-Identifier: BSD-3-Clause
#include "core/agent/none.hpp"

namespace swiftlet {
namespace {

class NoneAgent : public Agent {
 public:
  NoneAgent() {
    action_.mission = MissionStatus::kDone;
    action_.mission_note = "agent none: no mission";
  }
  const Action& step(const Observation& observation) override {
    action_.estimate.t = observation.t;
    return action_;
  }

 private:
  Action action_;
};

}  // namespace

std::unique_ptr<Agent> make_none(const ModuleConfig&, const AgentSetup&) { return std::make_unique<NoneAgent>(); }

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>

namespace swiftlet {

/// The parts of an agent's step, in the order of a stack. Other is what belongs to none of them.
enum class AgentStage {
  kLocalization,
  kClouds,
  kDetection,
  kTracking,
  kRelativeLocalization,
  kMapping,
  kGuidance,
  kControl,
  kOther
};
inline constexpr std::array<const char*, 9> kAgentStageNames = {
    "localization", "clouds",   "detection", "tracking", "relative_localization",
    "mapping",      "guidance", "control",   "other"};

/// An agent that tells which of its stages begins. So its stages can be timed, although it knows no clock.
class TellsStages {
 public:
  virtual ~TellsStages() = default;
  /// From now on each step calls `begins`, in its own thread, for every stage that the agent has. Empty: nobody
  /// listens.
  virtual void tell_stages(std::function<void(AgentStage)> begins) = 0;
};

}  // namespace swiftlet

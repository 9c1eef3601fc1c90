// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>

namespace swiftlet {

/// Parts of an agent's step, in the order of a stack. kOther: work outside of all stages.
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

/// An agent that reports which of its stages begins. So its stages can be timed, although it has no clock.
class StageNotifier {
 public:
  virtual ~StageNotifier() = default;
  /// From now on each step calls `begins`, in its own thread, at the beginning of every stage that the agent has.
  /// Empty: disabled.
  virtual void set_stage_listener(std::function<void(AgentStage)> begins) = 0;
};

}  // namespace swiftlet

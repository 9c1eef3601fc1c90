// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>

#include "swiftlet/core/agent/stage_notifier.hpp"

namespace swiftlet::sim {

/// Sums the duration of one agent's steps by stage. All time from start() to stop() belongs to one stage.
class AgentClock {
 public:
  void start() {
    stage_ = AgentStage::kOther;
    since_ = Clock::now();
  }
  void begin(AgentStage stage) {
    stop();
    stage_ = stage;
  }
  void stop() {
    const auto now = Clock::now();
    sums_s_[static_cast<std::size_t>(stage_)] += std::chrono::duration<double>(now - since_).count();
    since_ = now;
  }

  double seconds(AgentStage stage) const { return sums_s_[static_cast<std::size_t>(stage)]; }

 private:
  using Clock = std::chrono::steady_clock;
  std::array<double, kAgentStageNames.size()> sums_s_{};
  AgentStage stage_ = AgentStage::kOther;
  Clock::time_point since_;
};

}  // namespace swiftlet::sim

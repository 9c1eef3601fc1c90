// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace swiftlet::sim {

/// Parts of a tick, timed separately for the summary.
enum class Stage { kPhysics, kSensors, kAgents, kRadio, kMetrics, kRecorders };
inline constexpr std::array<const char*, 6> kStageNames = {"physics", "sensors", "agents",
                                                           "radio",   "metrics", "recorders"};

/// Sums wall time by stage. No result may depend on it.
class StageClock {
 public:
  class Scope {
   public:
    explicit Scope(double& sum_s) : sum_s_(sum_s) {}
    ~Scope() { sum_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    double& sum_s_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  };

  [[nodiscard]] Scope measure(Stage stage) {
    latest_ = stage;
    return Scope(sums_s_[static_cast<std::size_t>(stage)]);
  }
  /// The last stage passed to measure() or add().
  Stage latest() const { return latest_; }

  void add(Stage stage, double wall_s) {
    latest_ = stage;
    sums_s_[static_cast<std::size_t>(stage)] += wall_s;
  }

  std::vector<std::pair<std::string, double>> seconds_by_stage() const {
    std::vector<std::pair<std::string, double>> named;
    for (std::size_t i = 0; i < sums_s_.size(); ++i) named.emplace_back(kStageNames[i], sums_s_[i]);
    return named;
  }

 private:
  std::array<double, kStageNames.size()> sums_s_{};
  Stage latest_ = Stage::kPhysics;
};

}  // namespace swiftlet::sim

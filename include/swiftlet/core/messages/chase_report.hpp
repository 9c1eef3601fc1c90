// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// Report of an interceptor to its teammates: pursued target, earliest time of interception, and predicted path.
struct ChaseReport {
  static constexpr const char* kTopic = "chase";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "whom an interceptor chases, how soon it is there, and where it will be";

  /// kLeads: the teammates give way. kYields: a teammate intercepts earlier. kSearches: the target is lost. kCaught:
  /// the target is in the net.
  enum class Word { kIdle, kLeads, kYields, kSearches, kCaught };
  static constexpr std::array<const char*, 5> kWords = {"idle", "leads", "yields", "searches", "caught"};

  struct Place {
    Eigen::Vector3f p_world_m = Eigen::Vector3f::Zero();
    static void visit(auto& p, auto& v) { v.field("*_m", p.p_world_m, "[m] position"); }
  };

  TimeNs t = 0;
  Word word = Word::kIdle;
  double arrival_s = 0.0;
  Vector3 target_world_m = Vector3::Zero();
  Vector3 target_world_mps = Vector3::Zero();
  double interval_s = 0.0;
  std::vector<Place> places;

  static void visit(auto& m, auto& v) {
    v.time("t_s", m.t, "[s] of the first place");
    v.choice("word", m.word, kWords,
             "[-] leads: comes first; yields: keeps out of the way; searches: lost it; caught: has it");
    v.field("arrival_s", m.arrival_s, "[s] from now until it meets its target at the earliest");
    v.field("target_*_m", m.target_world_m, "[m] where its target is, in the world as the sender knows it");
    v.field("target_v*_mps", m.target_world_mps, "[m/s] velocity of its target, in the same axes");
    v.field("interval_s", m.interval_s, "[s] from place to place");
    v.list("num_places", m.places, "[-] where it will be [m], in the same world; then it goes straight on");
  }
};

}  // namespace swiftlet

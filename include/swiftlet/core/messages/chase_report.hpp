// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Report of an interceptor to its teammates: pursued target, earliest time of interception, and predicted path.
struct ChaseReport {
  static constexpr const char* kTopic = "chase";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "pursued target, earliest interception and predicted path of an interceptor";

  /// kLeads: the teammates give way. kYields: a teammate intercepts earlier. kSearches: the target is lost. kCaptured:
  /// the target is in the net.
  enum class Status { kIdle, kLeads, kYields, kSearches, kCaptured };
  static constexpr std::array<const char*, 5> kStatuses = {"idle", "leads", "yields", "searches", "captured"};

  struct Place {
    Eigen::Vector3f p_world_m = Eigen::Vector3f::Zero();
    static void visit(auto& p, auto& v) { v.field("*_m", p.p_world_m, "[m] position"); }
  };

  TimeNs t = 0;
  Status status = Status::kIdle;
  double arrival_s = 0.0;
  Vector3 target_world_m = Vector3::Zero();
  Vector3 target_world_mps = Vector3::Zero();
  double interval_s = 0.0;
  std::vector<Place> places;

  static void visit(auto& m, auto& v) {
    v.time("t_s", m.t, "[s] time of the first place");
    v.choice("status", m.status, kStatuses,
             "[-] leads: intercepts first; yields: keeps clear of the leader; searches: target lost; captured: target "
             "in the net");
    v.field("arrival_s", m.arrival_s, "[s] from now to the earliest interception");
    v.field("target_*_m", m.target_world_m, "[m] position of the target, in the sender's world frame");
    v.field("target_v*_mps", m.target_world_mps, "[m/s] velocity of the target, in the same axes");
    v.field("interval_s", m.interval_s, "[s] time between places");
    v.list("num_places", m.places, "[-] predicted positions [m], in the same frame; straight flight afterwards");
  }
};

}  // namespace swiftlet

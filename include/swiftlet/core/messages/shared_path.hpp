// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Predicted path of the sender, which stays at its last point.
struct SharedPath {
  static constexpr const char* kTopic = "shared_path";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "predicted path of the sender for the next seconds";

  /// kPlan: will be flown unless another vehicle reports a conflicting path.
  enum class Kind { kPlan, kFlown };
  static constexpr std::array<const char*, 2> kKinds = {"plan", "flown"};

  struct Place {
    Eigen::Vector3f p_world_m = Eigen::Vector3f::Zero();
    static void visit(auto& p, auto& v) { v.field("*_m", p.p_world_m, "[m] position"); }
  };

  Kind kind = Kind::kFlown;
  TimeNs t = 0;
  double interval_s = 0.0;
  std::vector<Place> places;

  static void visit(auto& m, auto& v) {
    v.choice("kind", m.kind, kKinds, "[-] plan: flown unless a conflicting path is received; flown: is being flown");
    v.time("t_s", m.t, "[s] time of the first place");
    v.field("interval_s", m.interval_s, "[s] time between places");
    v.list("num_places", m.places, "[-] places [m] in the sender's world frame");
  }
};

}  // namespace swiftlet

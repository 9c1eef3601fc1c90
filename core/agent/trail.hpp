// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/base/time.hpp"

namespace swiftlet {

/// At least the last 30 s of a path, as an overlay.
class Trail {
 public:
  void push(TimeNs t, const Vector3& p_local_m) {
    if (count_ > 0 && t - last_ < kNsPerSecond / 20) return;
    last_ = t;
    points_[(first_ + count_) % kCapacity] = p_local_m.cast<float>();
    if (count_ < kCapacity)
      ++count_;
    else
      first_ = (first_ + 1) % kCapacity;
  }
  Overlay overlay(const char* name) const {
    Overlay out;
    out.name = name;
    out.kind = Overlay::Kind::kPolyline;
    for (int i = 0; i < count_; ++i) out.positions.push_back(points_[(first_ + i) % kCapacity]);
    out.colors = {{0.1F, 0.6F, 1.0F, 1.0F}};
    out.size_m = 2.0F;  // width of a line in px
    return out;
  }

 private:
  /// [-] Stored positions, at least 50 ms apart. More of them make the trail longer.
  static constexpr int kCapacity = 600;
  std::array<Eigen::Vector3f, kCapacity> points_{};
  int first_ = 0, count_ = 0;
  TimeNs last_ = 0;
};

}  // namespace swiftlet

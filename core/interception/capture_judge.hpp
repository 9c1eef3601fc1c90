// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "swiftlet/core/base/capture_volume.hpp"

namespace swiftlet {

/// Target at the net, as the own track has it.
struct NetSighting {
  std::uint32_t track = 0;                     ///< id of the target's track
  Vector3 from_net_local_m = Vector3::Zero();  ///< displacement from the center of the net to the target
  std::optional<double> unmeasured_s;          ///< time since the last measurement; empty: never measured
};

/// Decides from the own track whether the net has captured the target: by the rule of the true captures, applied to a
/// track that was measured recently. A target counts again once it has been farther than the net's `rearm_m`.
class CaptureJudge {
 public:
  explicit CaptureJudge(const CaptureVolume& net) : net_(net) {}

  /// True in the tick of a capture.
  bool captures(const NetSighting& sighting);
  /// Discards the last position, so that the net does not sweep from it to the next one.
  void forget() { last_local_m_.reset(); }
  bool is_armed() const { return armed_; }
  int num_captures() const { return num_captures_; }

 private:
  CaptureVolume net_;
  std::uint32_t track_ = 0;
  std::optional<Vector3> last_local_m_;
  bool armed_ = true;
  int num_captures_ = 0;
};

}  // namespace swiftlet

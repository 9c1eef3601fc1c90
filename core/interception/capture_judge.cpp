// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/capture_judge.hpp"

namespace swiftlet {
namespace {

/// [s] Longest time since the last measurement at which a track that meets the net is a capture. The net hangs below
/// the field of view of a level LiDAR: shorter times miss captures, and after longer ones a maneuvering target has
/// moved on.
constexpr double kBlindTimeout_s = 1.0;

}  // namespace

bool CaptureJudge::captures(const NetSighting& sighting) {
  const Vector3& to_m = sighting.from_net_local_m;
  if (sighting.track != track_) last_local_m_.reset();
  track_ = sighting.track;
  if (to_m.norm() > net_.rearm_m) armed_ = true;
  const bool captured = armed_ && last_local_m_ && sighting.unmeasured_s && *sighting.unmeasured_s < kBlindTimeout_s &&
                        net_.met_m(*last_local_m_, to_m);
  last_local_m_ = to_m;
  if (!captured) return false;
  armed_ = false;
  ++num_captures_;
  return true;
}

}  // namespace swiftlet

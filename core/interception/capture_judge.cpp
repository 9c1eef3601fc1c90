// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/capture_judge.hpp"

namespace swiftlet {
namespace {

struct CaptureTuning {
  /// [s] Longest time since the last measurement at which a track that meets `sure_share` of the net is a capture.
  double sure_timeout_s = 0.5;
  /// [s] The same for a track that meets the net by its standard deviations. The net hangs where a level LiDAR sees
  /// nothing. Beyond this time, tracks of maneuvering targets are worse than their covariance.
  double precise_timeout_s = 1.0;
  double rim_sigmas = 2.0;     ///< [-] standard deviations of the track inside the rim, required for a capture
  double height_sigmas = 1.0;  ///< [-] the same inside the top and bottom
};
constexpr CaptureTuning kCapture;

}  // namespace

CaptureJudge::CaptureJudge(const CaptureVolume& net, double sure_share) : net_(net), sure_net_(net) {
  sure_net_.radius_m *= sure_share;
  sure_net_.height_m *= sure_share;
}

bool CaptureJudge::captures(const NetSighting& sighting) {
  if (sighting.track != track_) last_local_m_.reset();
  track_ = sighting.track;
  if (sighting.from_net_local_m.norm() > net_.rearm_m) armed_ = true;
  const bool captured = armed_ && last_local_m_ && sighting.unmeasured_s && meets_net(sighting);
  last_local_m_ = sighting.from_net_local_m;
  if (!captured) return false;
  armed_ = false;
  ++num_captures_;
  return true;
}

bool CaptureJudge::meets_net(const NetSighting& sighting) const {
  const Vector3 &from_m = *last_local_m_, &to_m = sighting.from_net_local_m;
  if (*sighting.unmeasured_s < kCapture.sure_timeout_s && sure_net_.met_m(from_m, to_m)) return true;
  CaptureVolume inside = net_;
  inside.radius_m -= kCapture.rim_sigmas * sighting.sigma_m;
  if (inside.height_m > 0.0) inside.height_m -= 2.0 * kCapture.height_sigmas * sighting.sigma_m;
  return *sighting.unmeasured_s < kCapture.precise_timeout_s && inside.radius_m > 0.0 && inside.height_m >= 0.0 &&
         inside.met_m(from_m, to_m);
}

}  // namespace swiftlet

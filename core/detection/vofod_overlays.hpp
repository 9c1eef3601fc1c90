// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/detection/vofod_stages.hpp"
#include "swiftlet/core/base/overlay.hpp"

namespace swiftlet {

/// Appends the occupied voxels by confidence, the voxels around the detections, the last scan by class, and its
/// detections. Local frame.
void append_vofod_overlays(const VofodStages& stages, double search_distance_m, std::span<const Detection> detections,
                           std::vector<Overlay>& overlays);

}  // namespace swiftlet

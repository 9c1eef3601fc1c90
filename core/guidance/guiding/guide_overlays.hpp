// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/planning/team_plan.hpp"

namespace swiftlet {

/// Overlays of a guide's plan: both paths, the regions that see the path, and the viewpoint.
void append_guide_overlays(const TeamPlan& plan, double height_local_m, std::vector<Overlay>& overlays);

}  // namespace swiftlet

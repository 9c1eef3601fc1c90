// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/overlay.hpp"
#include "swiftlet/core/planning/team_plan.hpp"

namespace swiftlet {

/// What a guide planned, for pictures: both paths, from where the path is seen, and the viewpoint.
void append_guide_overlays(const TeamPlan& plan, double height_local_m, std::vector<Overlay>& overlays);

}  // namespace swiftlet

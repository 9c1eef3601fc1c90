// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"

namespace swiftlet {

/// A guidance whose goals NeighborSafety admits: behind a plane, the goal moves to a point before it. The vehicle
/// yields, waits and evades, but does not resolve deadlocks. The guidance itself if `config` is not enabled.
/// @param planar  the guidance flies at one height
std::unique_ptr<Guidance> kept_apart(std::unique_ptr<Guidance> guidance, const KeepApartConfig& config,
                                     const GuidanceSetup& setup, bool planar = false);

}  // namespace swiftlet

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"

namespace swiftlet {

/// Wraps a guidance so that NeighborSafety admits its goals: a goal behind a plane is moved in front of the plane. The
/// vehicle yields, waits and evades, but does not resolve deadlocks. Returns the guidance itself if `config` is
/// disabled.
/// @param planar  the guidance flies at one height
std::unique_ptr<Guidance> kept_apart(std::unique_ptr<Guidance> guidance, const KeepApartConfig& config,
                                     const GuidanceSetup& setup, bool planar = false);

}  // namespace swiftlet

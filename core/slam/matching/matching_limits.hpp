// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Limits that different ways of matching share.
namespace swiftlet {

/// [m] Edge of the cubes that contribute one return each to a match with planes. Smaller cubes cost time.
inline constexpr float kMatchVoxel_m = 0.5F;
/// [-] Fewest points of a scan that is matched, and fewest pairs of its points with the map for an alignment. Smaller
/// values match scans that hardly meet the map.
inline constexpr int kMinReturns = 50;
/// [m], [rad] Step below which an alignment of two clouds has converged. Smaller values cost iterations.
inline constexpr double kConverged = 1e-4;

}  // namespace swiftlet

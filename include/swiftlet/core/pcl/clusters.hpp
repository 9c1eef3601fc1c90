// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/clusterer.hpp"

namespace swiftlet {

/// Clusters by PCL's EuclideanClusterExtraction, in the order defined by Clusterer.
std::unique_ptr<Clusterer> make_pcl_clusterer();

/// Plugs in PCL's implementations as "pcl": configurations may then use `clusterer: pcl`.
void plug_in_pcl();

}  // namespace swiftlet

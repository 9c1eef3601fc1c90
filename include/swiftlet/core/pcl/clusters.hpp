// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/clusterer.hpp"

namespace swiftlet {

/// Clusters by PCL's EuclideanClusterExtraction, in the order that Clusterer promises.
std::unique_ptr<Clusterer> make_pcl_clusterer();

/// Makes PCL's choices known by the name "pcl": from now on a configuration may say `clusterer: pcl`.
void plug_in_pcl();

}  // namespace swiftlet

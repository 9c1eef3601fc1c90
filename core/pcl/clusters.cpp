// SPDX-License-Identifier: BSD-3-Clause
// Instantiated here, so that a program with clusters loads libpcl_common only, not the eight libraries behind
// libpcl_segmentation.
#define PCL_NO_PRECOMPILE
#include "swiftlet/core/pcl/clusters.hpp"

#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>
#include <limits>

#include "core/pcl/clouds.hpp"

namespace swiftlet {
namespace {

class PclClusterer : public Clusterer {
 public:
  void compute(std::span<const Eigen::Vector3f> points_m, double tolerance_m) override {
    starts_.assign(1, 0);
    members_.clear();
    finite_.clear();
    for (std::uint32_t i = 0; i < points_m.size(); ++i) {
      if (points_m[i].allFinite()) finite_.push_back(static_cast<int>(i));
    }
    if (finite_.empty()) return;  // PCL's tree rejects empty clouds
    const auto cloud = to_pcl(points_m).makeShared();
    const auto indices = std::make_shared<pcl::Indices>(finite_);
    const auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>(false);
    pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
    extraction.setSearchMethod(tree);
    extraction.setClusterTolerance(tolerance_m);
    extraction.setMinClusterSize(1);
    extraction.setMaxClusterSize(std::numeric_limits<int>::max());
    extraction.setInputCloud(cloud);
    extraction.setIndices(indices);
    std::vector<pcl::PointIndices> clusters;
    extraction.extract(clusters);
    take_over(clusters);
  }

 private:
  void take_over(std::vector<pcl::PointIndices>& clusters) {
    for (pcl::PointIndices& cluster : clusters) std::sort(cluster.indices.begin(), cluster.indices.end());
    std::sort(clusters.begin(), clusters.end(),
              [](const auto& a, const auto& b) { return a.indices.front() < b.indices.front(); });
    for (const pcl::PointIndices& cluster : clusters) {
      members_.insert(members_.end(), cluster.indices.begin(), cluster.indices.end());
      starts_.push_back(static_cast<std::uint32_t>(members_.size()));
    }
  }

  pcl::Indices finite_;
};

}  // namespace

std::unique_ptr<Clusterer> make_pcl_clusterer() { return std::make_unique<PclClusterer>(); }

void plug_in_pcl() { plug_in_clusterer("pcl", make_pcl_clusterer); }

}  // namespace swiftlet

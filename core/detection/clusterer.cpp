// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/clusterer.hpp"

#include <map>
#include <stdexcept>

#include "swiftlet/core/detection/euclidean_clusters.hpp"

namespace swiftlet {
namespace {

// Not constant, unlike other tables: optional libraries register here.
std::map<std::string, MakeClusterer, std::less<>>& clusterers() {
  static std::map<std::string, MakeClusterer, std::less<>> table = {
      {"swiftlet", []() -> std::unique_ptr<Clusterer> { return std::make_unique<EuclideanClusters>(); }}};
  return table;
}

}  // namespace

std::unique_ptr<Clusterer> make_clusterer(const std::string& name) {
  const auto found = clusterers().find(name);
  if (found == clusterers().end()) throw std::invalid_argument("this program has no clusterer named '" + name + "'");
  return found->second();
}

bool has_clusterer(std::string_view name) { return clusterers().contains(name); }

void plug_in_clusterer(const std::string& name, MakeClusterer make) { clusterers()[name] = make; }

}  // namespace swiftlet

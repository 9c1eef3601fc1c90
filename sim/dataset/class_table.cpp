// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <cmath>
#include <map>

#include "swiftlet/sim/dataset/generate.hpp"
#include "swiftlet/sim/render/colors.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {
namespace {

/// Names of all classes by number.
std::map<int, std::string> classes() {
  std::map<int, std::string> names;
  for (const char* name : static_class_names()) names[static_cast<int>(*surface_class_of(name))] = name;
  names[0] = name_of(SurfaceClass::kUnlabeled);
  names[static_cast<int>(SurfaceClass::kVehicle)] = name_of(SurfaceClass::kVehicle);
  return names;
}

std::string list_of(const std::vector<SequenceInfo>& sequences, const std::string& split) {
  std::string text;
  for (const SequenceInfo& info : sequences) {
    if (info.split == split) text += "    - " + std::to_string(info.sequence) + "\n";
  }
  return text.empty() ? " []\n" : "\n" + text;
}

}  // namespace

std::string class_table(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences) {
  SequenceStatistics sum;
  for (const SequenceInfo& info : sequences) sum.add(info.statistics);
  const std::map<int, std::string> names = classes();

  std::string labels, colors, content, learning, inverse, ignore;
  int learned = 0;
  for (const auto& [label, name] : names) {
    const std::string key = "  " + std::to_string(label) + ": ";
    labels += key + "\"" + name + "\"\n";
    const Rgb color = label == 0 ? Rgb::Zero() : class_color(static_cast<std::uint16_t>(label));
    const auto byte = [&](int i) { return std::to_string(std::lround(255.0F * color[i])); };
    colors += key + "[" + byte(2) + ", " + byte(1) + ", " + byte(0) + "]\n";
    const auto found = sum.points_by_class.find(static_cast<std::uint16_t>(label));
    const double share = found == sum.points_by_class.end() || sum.points == 0
                             ? 0.0
                             : static_cast<double>(found->second) / static_cast<double>(sum.points);
    content += fmt::format("{}{:.9f}\n", key, share);
    learning += key + std::to_string(learned) + "\n";
    inverse += "  " + std::to_string(learned) + ": " + std::to_string(label) + "\n";
    ignore += "  " + std::to_string(learned) + (label == 0 ? ": True\n" : ": False\n");
    ++learned;
  }
  std::string text = "# Classes and splits of " + plan.config.name +
                     ", in the form of semantic-kitti-api's config/semantic-kitti.yaml.\nname: \"" + plan.config.name +
                     "\"\nlabels:\n" + labels + "color_map: # bgr\n" + colors + "content: # share of all points\n" +
                     content + "learning_map:\n" + learning + "learning_map_inv:\n" + inverse + "learning_ignore:\n" +
                     ignore + "split:\n";
  for (const SplitConfig& split : plan.config.splits) text += "  " + split.name + ":" + list_of(sequences, split.name);
  return text;
}

}  // namespace swiftlet::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/data_card.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/run/version.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

/// Formats with grouped digits: "1 234 567".
std::string grouped(std::int64_t value) {
  const std::string digits = std::to_string(value);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ' ';
    text += digits[i];
  }
  return text;
}

std::string bytes_text(double bytes) {
  if (bytes >= 1e9) return fmt::format("{:.2f} GB", bytes * 1e-9);
  if (bytes >= 1e6) return fmt::format("{:.1f} MB", bytes * 1e-6);
  return fmt::format("{:.0f} kB", bytes * 1e-3);
}

std::string name_of_label(std::uint16_t label) { return name_of(static_cast<SurfaceClass>(label)); }

struct Totals {
  SequenceStatistics statistics;
  std::set<int> flights;
  int sequences = 0;
  double bytes = 0.0;

  void add(const SequenceInfo& info) {
    statistics.add(info.statistics);
    flights.insert(info.flight);
    ++sequences;
    for (const FileEntry& file : info.files) bytes += static_cast<double>(file.bytes);
  }
  std::int64_t boxes() const { return sum(&SequenceStatistics::RangeBin::boxes); }
  std::int64_t sum(std::int64_t SequenceStatistics::RangeBin::*field) const {
    std::int64_t total = 0;
    for (const auto& bin : statistics.vehicles_by_range) total += bin.*field;
    return total;
  }
};

std::string split_table(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences, const Totals& all) {
  std::string text =
      "| split | seeds | flights | sequences | frames | points | vehicles in frames | duration | flown | size |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  const auto row = [&](const std::string& name, const std::string& seeds, const Totals& t) {
    text += "| " + name + " | " + seeds + " | " + std::to_string(t.flights.size()) + " | " +
            std::to_string(t.sequences) + " | " + grouped(t.statistics.frames) + " | " + grouped(t.statistics.points) +
            " | " + grouped(t.boxes()) + " | " + fmt::format("{:.0f} s", t.statistics.duration_s) + " | " +
            fmt::format("{:.0f} m", t.statistics.flown_m) + " | " + bytes_text(t.bytes) + " |\n";
  };
  for (const SplitConfig& split : plan.config.splits) {
    Totals totals;
    for (const SequenceInfo& info : sequences) {
      if (info.split == split.name) totals.add(info);
    }
    const std::uint64_t last = split.first_seed + static_cast<std::uint64_t>(std::max(split.flights, 1)) - 1;
    row(split.name, std::to_string(split.first_seed) + " to " + std::to_string(last), totals);
  }
  row("all", "", all);
  return text;
}

/// Points on other vehicles, and on the carrier of the LiDAR.
std::string vehicle_points(const Totals& all, std::int64_t on_vehicles) {
  std::int64_t on_others = 0;
  for (const SequenceStatistics::RangeBin& bin : all.statistics.vehicles_by_range) on_others += bin.points;
  return "| - other vehicles | | " + grouped(on_others) + " | |\n| - the LiDAR's own carrier | | " +
         grouped(on_vehicles - on_others) + " | |\n";
}

std::string class_histogram(const Totals& all) {
  std::vector<std::pair<std::int64_t, std::uint16_t>> counts;
  for (const auto& [label, count] : all.statistics.points_by_class) counts.emplace_back(-count, label);
  std::sort(counts.begin(), counts.end());
  std::string text = "| class | label | points | share |\n| --- | --- | --- | --- |\n";
  for (const auto& [negative, label] : counts) {
    const double share =
        static_cast<double>(-negative) / static_cast<double>(std::max<std::int64_t>(all.statistics.points, 1));
    text += "| " + name_of_label(label) + " | " + std::to_string(label) + " | " + grouped(-negative) + " | " +
            (share >= 1e-3 ? fmt::format("{:.2f} %", 100.0 * share) : fmt::format("{:.4f} %", 100.0 * share)) + " |\n";
    if (label == static_cast<std::uint16_t>(SurfaceClass::kVehicle)) text += vehicle_points(all, -negative);
  }
  return text;
}

/// Number of vehicles by distance, with `kStep` bins per row.
std::string distance_histogram(const Totals& all) {
  constexpr std::size_t kStep = 5;
  std::string text =
      "| distance | vehicles in frames | visible | with points | with 5 points or more | points each, where any |\n"
      "| --- | --- | --- | --- | --- | --- |\n";
  const auto& bins = all.statistics.vehicles_by_range;
  for (std::size_t first = 0; first < bins.size(); first += kStep) {
    SequenceStatistics::RangeBin sum;
    const std::size_t end = std::min(first + kStep, bins.size());
    for (std::size_t i = first; i < end; ++i) {
      sum.boxes += bins[i].boxes;
      sum.in_view += bins[i].in_view;
      sum.detected += bins[i].detected;
      sum.well_detected += bins[i].well_detected;
      sum.points += bins[i].points;
    }
    if (sum.boxes == 0) continue;
    const auto meters = [](std::size_t bin) {
      return fmt::format("{:.0f}", static_cast<double>(bin) * SequenceStatistics::kRangeBin_m);
    };
    text +=
        "| " + meters(first) + (end == bins.size() ? " m and more" : " to " + meters(end) + " m") + " | " +
        grouped(sum.boxes) + " | " + grouped(sum.in_view) + " | " + grouped(sum.detected) + " | " +
        grouped(sum.well_detected) + " | " +
        (sum.detected > 0 ? fmt::format("{:.1f}", static_cast<double>(sum.points) / static_cast<double>(sum.detected))
                          : "") +
        " |\n";
  }
  return text;
}

std::string sequence_table(const std::vector<SequenceInfo>& sequences) {
  std::string text =
      "| sequence | split | seed | family | LiDAR | vehicles | frames | points a frame | flown | least clearance |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const SequenceInfo& info : sequences) {
    const SequenceStatistics& s = info.statistics;
    std::string models;
    for (const std::string& model : info.models) models += (models.empty() ? "" : ", ") + model;
    text += "| " + sequence_name(info.sequence) + " | " + info.split + " | " + std::to_string(info.seed) + " | " +
            info.family + " | " + info.vehicle + "/" + info.sensor +
            (info.sensor_model.empty() ? "" : " (" + info.sensor_model + ")") + " | " + models + " | " +
            grouped(s.frames) + " | " + grouped(s.points / std::max<std::int64_t>(s.frames, 1)) + " | " +
            fmt::format("{:.0f} m", s.flown_m) + " | " + fmt::format("{:.2f} m", s.least_clearance_m) + " |\n";
  }
  return text;
}

std::string randomization_table(const DatasetConfig& config) {
  std::string text =
      "| family | key | law | values |\n"
      "| --- | --- | --- | --- |\n";
  for (const FamilyConfig& family : config.families) {
    for (const VariationConfig& variation : family.vary) {
      std::string values;
      for (const std::string& choice : variation.choices) values += (values.empty() ? "" : ", ") + choice;
      if (values.empty()) values = fmt::format("{:g}", variation.min) + " to " + fmt::format("{:g}", variation.max);
      text += "| " + family.name + " | `" + variation.key + "` | " +
              VariationConfig::kLaws[static_cast<std::size_t>(variation.law)] + " | " + values + " |\n";
    }
    if (family.reflectivity_spread > 0.0) {
      text += "| " + family.name + " | reflectivity of each material | log-normal | x exp(" +
              fmt::format("{:g}", family.reflectivity_spread) + " n) |\n";
    }
    text += "| " + family.name + " | cruise speed | uniform | " + fmt::format("{:g}", family.flight.speed_min_mps) +
            " to " + fmt::format("{:g}", family.flight.speed_max_mps) + " m/s |\n";
    text += "| " + family.name + " | height above ground | uniform | " +
            fmt::format("{:g}", family.flight.height_min_m) + " to " + fmt::format("{:g}", family.flight.height_max_m) +
            " m |\n";
  }
  return text;
}

void draw_class_chart(const Totals& all, const fs::path& path) {
  std::vector<std::pair<std::int64_t, std::uint16_t>> counts;
  for (const auto& [label, count] : all.statistics.points_by_class) counts.emplace_back(-count, label);
  std::sort(counts.begin(), counts.end());
  std::vector<double> shares;
  std::vector<std::string> names;
  for (const auto& [negative, label] : counts) {
    shares.push_back(100.0 * static_cast<double>(-negative) / static_cast<double>(all.statistics.points));
    names.push_back(name_of_label(label));
  }
  plot::Figure figure("Points by class");
  figure.set_panel_size(760, 380);
  plot::Panel& panel = figure.add_panel();
  panel.x.categories = names;
  panel.y.label = "share of all points [%]";
  panel.y.log = true;
  panel.bars("", shares);
  figure.write(path);
}

void draw_distance_chart(const Totals& all, const fs::path& path) {
  const auto& bins = all.statistics.vehicles_by_range;
  std::size_t end = bins.size();
  while (end > 1 && bins[end - 1].boxes == 0) --end;
  std::vector<double> middle_m, boxes, in_view, detected, well_detected, points;
  for (std::size_t i = 0; i < end; ++i) {
    const auto& bin = bins[i];
    middle_m.push_back((static_cast<double>(i) + 0.5) * SequenceStatistics::kRangeBin_m);
    boxes.push_back(static_cast<double>(bin.boxes));
    in_view.push_back(static_cast<double>(bin.in_view));
    detected.push_back(static_cast<double>(bin.detected));
    well_detected.push_back(static_cast<double>(bin.well_detected));
    points.push_back(bin.detected > 0 ? static_cast<double>(bin.points) / static_cast<double>(bin.detected)
                                      : std::nan(""));
  }
  plot::Figure figure("Vehicles by distance", 2);
  plot::Panel& counts = figure.add_panel("how many");
  counts.x.label = "distance to the LiDAR [m]";
  counts.y.label = "vehicles in frames, by 2 m";
  counts.line("in frames", middle_m, boxes).line("visible", middle_m, in_view);
  counts.line("with points", middle_m, detected).line("with 5 points or more", middle_m, well_detected);
  plot::Panel& each = figure.add_panel("how well");
  each.x.label = "distance to the LiDAR [m]";
  each.y.label = "points on a vehicle that has any";
  each.y.log = true;
  each.line("", middle_m, points, {.marker = plot::Marker::kCircle});
  figure.write(path);
}

void draw_range_chart(const Totals& all, const fs::path& path) {
  const auto& bins = all.statistics.points_by_range;
  std::vector<double> middle_m, share;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    middle_m.push_back((static_cast<double>(i) + 0.5) * SequenceStatistics::kRangeBin_m);
    share.push_back(100.0 * static_cast<double>(bins[i]) / static_cast<double>(all.statistics.points));
  }
  plot::Figure figure("Points by range");
  plot::Panel& panel = figure.add_panel();
  panel.x.label = "range [m]";
  panel.y.label = "share of all points, by 2 m [%]";
  panel.line("", middle_m, share);
  figure.write(path);
}

std::string pictures(const std::vector<SequenceInfo>& sequences) {
  std::string text;
  for (const SequenceInfo& info : sequences) {
    for (const FileEntry& file : info.files) {
      if (!file.path.starts_with("snapshots/") || !file.path.ends_with(".png") || file.path.ends_with(".mm.png"))
        continue;
      const std::string path = "sequences/" + sequence_name(info.sequence) + "/" + file.path;
      text += "![sequence " + sequence_name(info.sequence) + ", " + fs::path(file.path).stem().string() + "](" + path +
              ")\n\n";
    }
  }
  return text;
}

}  // namespace

void write_data_card(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences, const fs::path& directory) {
  Totals all;
  for (const SequenceInfo& info : sequences) all.add(info);
  const DatasetConfig& config = plan.config;
  std::string text = "# " + config.name + "\n\n";
  if (!config.description.empty()) text += config.description + "\n\n";
  text += "Simulated by Swiftlet " + std::string(version()) + " (" + git_revision() +
          "); fingerprint of the configuration `" + plan.fingerprint +
          "`. Everything is a pure function of the seeds: `swiftlet dataset verify DIR` compares every hash with "
          "manifest.json and simulates random frames again, bit for bit.\n\n";
  text += "## Splits\n\n" + split_table(plan, sequences, all) + "\n";
  const std::string outside = poses_outside(sequences);
  if (!outside.empty()) text += outside + ".\n\n";
  text +=
      "The splits have no world in common. `semantic-kitti.yaml` names classes, colors and splits in the "
      "form "
      "of semantic-kitti-api.\n\n";
  if (all.statistics.points > 0) {
    make_inner_directory(directory / "charts");
    draw_class_chart(all, directory / "charts/classes.svg");
    draw_range_chart(all, directory / "charts/ranges.svg");
    text += "## Classes\n\n![points by class](charts/classes.svg)\n\n" + class_histogram(all) + "\n";
    text += "## Ranges\n\n![points by range](charts/ranges.svg)\n\n";
  }
  if (all.boxes() > 0) {
    draw_distance_chart(all, directory / "charts/distances.svg");
    text += "## Vehicles by distance\n\nOf the " + grouped(all.boxes()) + " vehicles in frames, " +
            grouped(all.sum(&SequenceStatistics::RangeBin::in_view)) +
            " are visible (at least a tenth of the silhouette in the field of view with nothing in front) and " +
            grouped(all.sum(&SequenceStatistics::RangeBin::detected)) +
            " have points.\n\n![vehicles by distance](charts/distances.svg)\n\n" + distance_histogram(all) + "\n";
  }
  const std::string shown = pictures(sequences);
  if (!shown.empty()) text += "## Pictures\n\n" + shown;
  text += "## Random values of each flight\n\n" + randomization_table(config) + "\n";
  text += "## Sequences\n\n" + sequence_table(sequences) + "\n";
  text += "## Files\n\nThe layout is that of SemanticKITTI; docs/datasets.md of Swiftlet describes every file.\n";
  write_file(directory / "README.md", text);
}

}  // namespace swiftlet::sim

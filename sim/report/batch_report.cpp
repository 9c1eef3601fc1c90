// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/report/batch_report.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "sim/report/group_samples.hpp"
#include "sim/report/html.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/shallow_json.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

// [-] Largest numbers of worst episodes and failures that the page lists. Larger values make the page longer.
constexpr std::size_t kWorst = 10;
constexpr std::size_t kFailures = 20;
// [-] Largest number of points side by side in a box plot, and of groups with a table of every metric. With more
// points, a variant has one box for all of them.
constexpr std::size_t kMaxBoxes = 12;
// [-] Largest number of rows of a figure of intervals; further groups are left out.
constexpr std::size_t kMaxIntervals = 40;
// [-] Largest number of values of a parameter for which the plot has means; with more values, it has single episodes.
constexpr std::size_t kMaxLevels = 20;
// [-] Largest number of groups in a table of the page; report.csv contains all groups.
constexpr std::size_t kMaxGroupRows = 200;

std::string plural(std::uint64_t count, const std::string& word) {
  return std::to_string(count) + " " + word + (count == 1 ? "" : "s");
}

std::string percent(double rate) { return std::isfinite(rate) ? html::number(100.0 * rate) + " %" : "–"; }
std::string percent(const Interval& ci) { return html::interval(100.0 * ci.low, 100.0 * ci.high); }

std::optional<double> as_number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::uint64_t count_done(const BatchTable& table, const EpisodeGroup& group) {
  return static_cast<std::uint64_t>(std::count_if(group.episodes.begin(), group.episodes.end(),
                                                  [&](std::size_t i) { return table.episodes[i].done(); }));
}

SampleSummary summary_of(const BatchTable& table, const Quantity& quantity, const EpisodeGroup& group) {
  return summarize(values_of(quantity, group), seeds_of(table, group));
}

Interval rate_interval(const BatchTable& table, const std::string& outcome, const EpisodeGroup& group) {
  const std::vector<double> outcomes = outcomes_of(table, outcome, group);
  return wilson(count_outcome(table, outcome, group), count_done(table, group),
                independent_share(outcomes, seeds_of(table, group)));
}

// --- header ---

std::string heading(const BatchTable& table) {
  const BatchInfo& info = table.info;
  std::map<std::string, std::uint64_t> by_status;
  for (const EpisodeRow& row : table.episodes) ++by_status[row.status];
  std::string statuses;
  for (const auto& [status, count] : by_status) statuses += ", " + std::to_string(count) + " " + status;
  std::string text = "<h1>" + escape_markup(info.name) + "</h1>\n";
  if (!info.description.empty()) text += "<p>" + escape_markup(info.description) + "</p>\n";
  text +=
      "<p class=\"note\">" + plural(table.episodes.size(), "episode") + " of " + std::to_string(info.num_episodes) +
      escape_markup(statuses) + ". Swiftlet " + escape_markup(info.version) + " (" + escape_markup(info.git_revision) +
      "), fingerprint " + html::code(info.fingerprint) +
      ". Intervals are of 95 %: Student's t for means, Wilson's for rates. Over several points they count a seed once, "
      "since it has the same random numbers at each.";
  if (info.variants.size() > 1) {
    text += " Differences are to <b>" + escape_markup(info.variants.front()) +
            "</b>, seed by seed: both variants have the same random numbers.";
  }
  return text + "</p>\n";
}

/// All points together, then each point unless it is a single episode, up to kMaxGroupRows.
std::vector<const EpisodeGroup*> groups_shown(const BatchTable& table) {
  std::vector<const EpisodeGroup*> shown;
  for (const EpisodeGroup& group : table.totals) shown.push_back(&group);
  const bool single = std::all_of(table.groups.begin(), table.groups.end(),
                                  [](const EpisodeGroup& group) { return group.episodes.size() < 2; });
  if (single && !shown.empty()) return shown;
  for (std::size_t i = 0; i < std::min(table.groups.size(), kMaxGroupRows); ++i) shown.push_back(&table.groups[i]);
  return shown;
}

// --- interval plots ---

struct IntervalRow {
  std::string name;
  double center = 0.0;
  Interval ci;
};

/// A row for each group, the first at the top: a marker and its interval.
std::string interval_plot(const std::string& label, const std::vector<IntervalRow>& rows, bool is_difference,
                          bool is_rate) {
  if (rows.empty()) return "";
  plot::Figure figure;
  figure.set_panel_size(620.0, 70.0 + 22.0 * static_cast<double>(rows.size()));
  plot::Panel& panel = figure.add_panel();
  panel.x.label = label;
  panel.legend = plot::Legend::kNone;
  if (is_rate && !is_difference) {
    panel.x.min = 0.0;
    panel.x.max = 100.0;
  }
  plot::Style mark;
  mark.color = 0;
  mark.marker = plot::Marker::kSquare;
  mark.marker_px = 4.0;
  plot::Style bar;
  bar.color = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const IntervalRow& row = rows[rows.size() - 1 - i];
    panel.y.categories.push_back(row.name);
    const double at[] = {static_cast<double>(i), static_cast<double>(i)}, ends[] = {row.ci.low, row.ci.high};
    if (std::isfinite(row.ci.low) && std::isfinite(row.ci.high)) panel.line("", ends, at, bar);
    if (std::isfinite(row.center)) panel.scatter("", {&row.center, 1}, {at, 1}, mark);
  }
  if (is_difference) panel.vertical("", 0.0, {.color = 7, .width_px = 1.0, .dash = plot::Dash::kDashed});
  return "<figure>" + figure.svg() + "</figure>\n";
}

/// The groups of the tables, limited to the size of a figure.
std::vector<const EpisodeGroup*> groups_plotted(const BatchTable& table) {
  std::vector<const EpisodeGroup*> shown = groups_shown(table);
  shown.resize(std::min(shown.size(), kMaxIntervals));
  return shown;
}

std::string outcome_plots(const BatchTable& table) {
  std::string text;
  const std::vector<const EpisodeGroup*> groups = groups_plotted(table);
  if (groups.size() < 2) return text;
  for (const std::string& outcome : table.outcomes) {
    std::vector<IntervalRow> rows;
    for (const EpisodeGroup* group : groups) {
      const std::uint64_t done = count_done(table, *group);
      if (done == 0) continue;
      const Interval ci = rate_interval(table, outcome, *group);
      const double rate = static_cast<double>(count_outcome(table, outcome, *group)) / static_cast<double>(done);
      rows.push_back({table.name_of(*group), 100.0 * rate, {100.0 * ci.low, 100.0 * ci.high}});
    }
    text += interval_plot(outcome + " [% of episodes]", rows, false, true);
  }
  return text;
}

/// Paired differences of each variant to the reference variant, over equal seeds.
std::string difference_plot(const BatchTable& table, const Quantity& quantity) {
  if (table.info.variants.size() < 2) return "";
  std::vector<IntervalRow> rows;
  for (const EpisodeGroup* group : groups_plotted(table)) {
    const EpisodeGroup* reference = table.reference_of(*group);
    if (reference == nullptr) continue;
    const PairedValues pairs = paired_values(table, quantity, *reference, *group);
    const SampleSummary d = paired_difference(pairs.first, pairs.second, pairs.seeds);
    if (d.n > 0) rows.push_back({table.name_of(*group), d.mean, d.mean_ci});
  }
  return interval_plot("difference of " + quantity.label() + " to " + table.info.variants.front(), rows, true, false);
}

// --- outcomes ---

std::string outcome_section(const BatchTable& table) {
  std::vector<std::string> head = {"", "episodes"};
  for (const std::string& outcome : table.outcomes)
    head.insert(head.end(), {escape_markup(outcome), "95 % interval", "difference", "95 % interval"});
  if (table.info.variants.size() < 2) {
    head.resize(2);
    for (const std::string& outcome : table.outcomes)
      head.insert(head.end(), {escape_markup(outcome), "95 % interval"});
  }
  html::Table rows(head);
  for (const EpisodeGroup* shown : groups_shown(table)) {
    const EpisodeGroup& group = *shown;
    const std::uint64_t done = count_done(table, group);
    std::vector<std::string> cells = {escape_markup(table.name_of(group)), std::to_string(done)};
    for (const std::string& outcome : table.outcomes) {
      const std::uint64_t count = count_outcome(table, outcome, group);
      cells.push_back(percent(done > 0 ? static_cast<double>(count) / static_cast<double>(done) : std::nan("")));
      cells.push_back(percent(rate_interval(table, outcome, group)));
      if (table.info.variants.size() < 2) continue;
      const EpisodeGroup* reference = table.reference_of(group);
      const RateDifference d =
          reference ? paired_rate_difference(paired_outcomes(table, outcome, *reference, group)) : RateDifference{};
      cells.push_back(percent(d.difference));
      cells.push_back(percent(d.ci));
    }
    rows.add(std::move(cells));
  }
  std::string text = rows.str();
  if (table.groups.size() > kMaxGroupRows) text += "<p class=\"note\">The rest is in report.csv.</p>\n";
  return html::section("Outcomes", outcome_plots(table) + text);
}

// --- one quantity ---

std::vector<double> numbers_only(const std::vector<double>& values) {
  std::vector<double> numbers;
  std::copy_if(values.begin(), values.end(), std::back_inserter(numbers), [](double x) { return std::isfinite(x); });
  return numbers;
}

/// Distinct points in order, with their names.
std::vector<std::pair<std::size_t, std::string>> points_of(const BatchTable& table) {
  std::vector<std::pair<std::size_t, std::string>> points;
  for (const EpisodeGroup& group : table.groups) {
    if (points.empty() || points.back().first != group.point) points.emplace_back(group.point, table.point_name(group));
  }
  return points;
}

/// Box plots of every variant at every point, or of all points together when they are many.
std::string box_plot(const BatchTable& table, const Quantity& quantity) {
  const auto points = points_of(table);
  const bool by_point = points.size() > 1 && points.size() <= kMaxBoxes;
  plot::Figure figure;
  figure.set_panel_size(
      by_point ? std::max(420.0, 70.0 * static_cast<double>(points.size() * table.info.variants.size()) / 2.0 + 240.0)
               : 420.0,
      330.0);
  plot::Panel& panel = figure.add_panel();
  panel.y.label = quantity.label();
  if (by_point) {
    for (const auto& [point, name] : points) panel.x.categories.push_back(name);
  } else {
    panel.x.categories = table.info.variants;
    panel.legend = plot::Legend::kNone;
  }
  std::map<std::pair<std::size_t, std::string>, std::vector<double>> samples;  // indexed by point (0: all) and variant
  for (const EpisodeGroup& group : table.groups) {
    auto& own = samples[{by_point ? group.point : 0, group.variant}];
    for (const double x : numbers_only(values_of(quantity, group))) own.push_back(x);
  }
  const auto box = [&](std::size_t point, const std::string& variant) {
    const auto& own = samples[{point, variant}];
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return own.empty() ? plot::Box{kNone, kNone, kNone, kNone, kNone, kNone, {}} : plot::box_of(own);
  };
  if (by_point) {
    for (const std::string& variant : table.info.variants) {
      std::vector<plot::Box> boxes;
      for (const auto& [point, name] : points) boxes.push_back(box(point, variant));
      panel.boxes(table.info.variants.size() > 1 ? variant : "", std::move(boxes));
    }
  } else {
    std::vector<plot::Box> boxes;
    for (const std::string& variant : table.info.variants) boxes.push_back(box(0, variant));
    panel.boxes("", std::move(boxes));
  }
  return "<figure>" + figure.svg() + "</figure>\n";
}

/// Plots the quantity over one parameter for each variant: means and intervals at every value, averaged over all other
/// parameters; single episodes where the values are many.
void add_sweep(plot::Panel& panel, const BatchTable& table, const Quantity& quantity, std::size_t parameter,
               const std::string& variant) {
  std::map<double, std::vector<double>> levels;
  std::map<double, std::vector<std::uint64_t>> seeds;
  for (const EpisodeGroup& group : table.groups) {
    const auto x = as_number(group.parameters[parameter]);
    if (group.variant != variant || !x) continue;
    for (const std::size_t i : group.episodes) {
      if (!std::isfinite(quantity.values[i])) continue;
      levels[*x].push_back(quantity.values[i]);
      seeds[*x].push_back(table.episodes[i].seed);
    }
  }
  const std::string label = table.info.variants.size() > 1 ? variant : "";
  std::vector<double> x, y, low, high;
  const std::size_t num_values =
      std::accumulate(levels.begin(), levels.end(), std::size_t{0},
                      [](std::size_t n, const auto& level) { return n + level.second.size(); });
  if (levels.size() > kMaxLevels || num_values < 2 * levels.size()) {  // continuous samples instead of levels
    for (const auto& [level, values] : levels) {
      for (const double value : values) {
        x.push_back(level);
        y.push_back(value);
      }
    }
    panel.scatter(label, x, y);
    return;
  }
  for (const auto& [level, values] : levels) {
    const SampleSummary s = summarize(values, seeds[level]);
    x.push_back(level);
    y.push_back(s.mean);
    low.push_back(std::isfinite(s.mean_ci.low) ? s.mean_ci.low : s.mean);
    high.push_back(std::isfinite(s.mean_ci.high) ? s.mean_ci.high : s.mean);
  }
  plot::Style style;
  style.marker = plot::Marker::kCircle;
  const auto& variants = table.info.variants;
  style.color = static_cast<int>(std::find(variants.begin(), variants.end(), variant) - variants.begin());
  panel.band("", x, low, high, style).line(label, x, y, style);
}

std::string sweep_plots(const BatchTable& table, const Quantity& quantity) {
  std::string text;
  for (std::size_t p = 0; p < table.info.parameters.size(); ++p) {
    std::set<double> values;
    for (const EpisodeGroup& group : table.groups) {
      if (const auto value = as_number(group.parameters[p])) values.insert(*value);
    }
    if (values.size() < 2) continue;
    plot::Figure figure;
    figure.set_panel_size(440.0, 330.0);
    plot::Panel& panel = figure.add_panel();
    panel.x.label = table.info.parameters[p];
    panel.y.label = quantity.label();
    const auto& parameters = table.config.sweep.parameters;
    panel.x.log = p < parameters.size() && parameters[p].law == ParameterConfig::Law::kLogUniform;
    for (const std::string& variant : table.info.variants) add_sweep(panel, table, quantity, p, variant);
    text += "<figure>" + figure.svg() + "</figure>\n";
  }
  return text;
}

std::vector<std::string> summary_cells(const SampleSummary& s) {
  return {
      std::to_string(s.n), html::number(s.mean),   html::number(s.sd), html::interval(s.mean_ci.low, s.mean_ci.high),
      html::number(s.min), html::number(s.median), html::number(s.max)};
}

std::string quantity_table(const BatchTable& table, const Quantity& quantity) {
  std::vector<std::string> head = {"", "n", "mean", "sd", "95 % interval", "least", "median", "greatest"};
  const bool paired = table.info.variants.size() > 1;
  if (paired) head.insert(head.end(), {"pairs", "difference", "sd", "95 % interval"});
  html::Table rows(head);
  for (const EpisodeGroup* shown : groups_shown(table)) {
    const EpisodeGroup& group = *shown;
    std::vector<std::string> cells = {escape_markup(table.name_of(group))};
    for (std::string& cell : summary_cells(summary_of(table, quantity, group))) cells.push_back(std::move(cell));
    if (const EpisodeGroup* reference = table.reference_of(group)) {
      const PairedValues pairs = paired_values(table, quantity, *reference, group);
      const SampleSummary d = paired_difference(pairs.first, pairs.second, pairs.seeds);
      cells.insert(cells.end(), {std::to_string(d.n), html::number(d.mean), html::number(d.sd),
                                 html::interval(d.mean_ci.low, d.mean_ci.high)});
    } else if (paired) {
      cells.insert(cells.end(), 4, "");
    }
    rows.add(std::move(cells));
  }
  return rows.str();
}

std::string quantity_section(const BatchTable& table, const Quantity& quantity) {
  return html::section(quantity.label(), box_plot(table, quantity) + difference_plot(table, quantity) +
                                             sweep_plots(table, quantity) + quantity_table(table, quantity));
}

/// Summary of every quantity, over all groups.
std::string all_quantities(const BatchTable& table) {
  std::string text;
  const std::vector<const EpisodeGroup*> shown = groups_shown(table);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    if (i == kMaxBoxes) {
      text += "<p class=\"note\">The other groups are in report.csv.</p>\n";
      break;
    }
    const EpisodeGroup& group = *shown[i];
    html::Table rows({"", "n", "mean", "sd", "95 % interval", "least", "median", "greatest"});
    for (const Quantity& quantity : table.quantities) {
      std::vector<std::string> cells = {escape_markup(quantity.label())};
      for (std::string& cell : summary_cells(summary_of(table, quantity, group))) cells.push_back(std::move(cell));
      rows.add(std::move(cells));
    }
    text += html::folded("Every metric: " + table.name_of(group), rows.str());
  }
  return text;
}

// --- single episodes ---

const Quantity* worst_by(const BatchTable& table, const std::vector<const Quantity*>& informative) {
  if (!table.config.report.worst_by.empty()) {
    for (const Quantity& q : table.quantities) {
      if (q.metric == table.config.report.worst_by || q.vehicle + "." + q.metric == table.config.report.worst_by)
        return &q;
    }
  }
  return informative.empty() ? nullptr : informative.front();
}

/// Indices of episodes, worst first.
std::vector<std::size_t> worst_first(const BatchTable& table, const Quantity& quantity) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < table.episodes.size(); ++i) {
    if (std::isfinite(quantity.values[i])) order.push_back(i);
  }
  const bool high = table.config.report.worst_is == ReportConfig::WorstIs::kHigh;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return high ? quantity.values[a] > quantity.values[b] : quantity.values[a] < quantity.values[b];
  });
  return order;
}

/// Embedded replays of the given episodes, as far as the batch directory contains them.
std::string replays_of(const BatchTable& table, const std::vector<std::size_t>& order, const fs::path& directory) {
  std::string text;
  for (const std::size_t i : order) {
    const EpisodeRow& row = table.episodes[i];
    if (!has_replay(directory, row)) continue;
    const fs::path page = replay_of_episode(row.id) / "replay.html";
    text +=
        html::folded("Episode " + std::to_string(row.id) + ", " + row.variant + ", seed " + std::to_string(row.seed),
                     html::replay_frame(page.generic_string()));
  }
  return text.empty() ? "<p class=\"note\">" + html::code("swiftlet batch ... --resume --replays 3") +
                            " puts the first of them here, to play in the browser.</p>\n"
                      : text;
}

std::string worst_section(const BatchTable& table, const Quantity& quantity, const fs::path& directory) {
  std::vector<std::size_t> order = worst_first(table, quantity);
  if (order.size() > kWorst) order.resize(kWorst);
  html::Table rows({"episode", "variant", "seed", "outcome", escape_markup(quantity.label()), "flown again by"},
                   {0, 1, 3, 5});
  for (const std::size_t i : order) {
    const EpisodeRow& row = table.episodes[i];
    rows.add({std::to_string(row.id), escape_markup(row.variant), std::to_string(row.seed), escape_markup(row.outcome),
              html::number(quantity.values[i]), html::code(row.command + " --replay")});
  }
  const bool high = table.config.report.worst_is == ReportConfig::WorstIs::kHigh;
  return html::section(std::string("Worst episodes: ") + (high ? "greatest " : "least ") + quantity.label(),
                       rows.str() + replays_of(table, order, directory));
}

std::string failure_section(const BatchTable& table) {
  html::Table rows({"episode", "variant", "seed", "what happened", "", "flown again by"}, {0, 1, 3, 4, 5});
  std::size_t count = 0;
  for (const EpisodeRow& row : table.episodes) {
    if (row.done() || ++count > kFailures) continue;
    rows.add({std::to_string(row.id), escape_markup(row.variant), std::to_string(row.seed), escape_markup(row.status),
              escape_markup(row.message), html::code(row.command)});
  }
  if (count == 0) return "";
  const std::string more = count > kFailures ? "<p class=\"note\">" + std::to_string(count - kFailures) +
                                                   " more in the database's view <i>failures</i>.</p>\n"
                                             : "";
  return html::section("Episodes that are not done: " + std::to_string(count), rows.str() + more);
}

std::string timing_section(const BatchTable& table) {
  std::vector<double> wall_s, setup_s, flight_s, factor;
  std::uint64_t worlds = 0;
  for (const EpisodeRow& row : table.episodes) {
    wall_s.push_back(row.wall_s);
    setup_s.push_back(row.setup_wall_s);
    flight_s.push_back(row.flight_wall_s);
    factor.push_back(row.simulated_s / row.flight_wall_s);
    worlds += row.built_world ? 1 : 0;
  }
  html::Table rows({"", "n", "mean", "sd", "95 % interval", "least", "median", "greatest"});
  const auto add = [&](const std::string& name, const std::vector<double>& values) {
    std::vector<std::string> cells = {name};
    for (std::string& cell : summary_cells(summarize(values))) cells.push_back(std::move(cell));
    rows.add(std::move(cells));
  };
  add("whole episode [s]", wall_s);
  add("set-up [s]", setup_s);
  add("flight [s]", flight_s);
  add("times real time", factor);
  return html::section("Wall time", rows.str() + "<p class=\"note\">" + plural(worlds, "world") + " built for " +
                                        plural(table.episodes.size(), "episode") + ".</p>\n");
}

// --- CSV ---

std::string csv_head(const EpisodeGroup& group, std::size_t num_parameters) {
  const bool all = group.point == EpisodeGroup::kAllPoints;
  std::string text = (all ? "all" : std::to_string(group.point)) + "," + csv_cell(group.variant);
  for (std::size_t i = 0; i < num_parameters; ++i) text += "," + (all ? "" : csv_cell(group.parameters[i]));
  return text;
}

}  // namespace

fs::path replay_of_episode(std::uint64_t id) { return fs::path("replays") / std::to_string(id); }

bool has_replay(const fs::path& directory, const EpisodeRow& row) {
  const fs::path run = directory / replay_of_episode(row.id);
  if (!fs::is_regular_file(run / "replay.html") || !fs::is_regular_file(run / "summary.json")) return false;
  const auto summary = parse_shallow<nlohmann::json>(read_whole_file(run / "summary.json"));
  return summary.is_object() && summary.value("state_hash", nlohmann::json()) == row.state_hash;
}

std::vector<EpisodeRow> worst_episodes(const BatchTable& table, std::size_t count) {
  const Quantity* quantity = worst_by(table, informative_quantities(table));
  std::vector<EpisodeRow> rows;
  if (quantity == nullptr) return rows;
  for (const std::size_t i : worst_first(table, *quantity)) {
    if (rows.size() == count) break;
    rows.push_back(table.episodes[i]);
  }
  return rows;
}

std::string batch_report_html(const BatchTable& table, const fs::path& directory) {
  const auto informative = informative_quantities(table);
  std::string body = heading(table) + outcome_section(table);
  for (const Quantity* quantity : informative) body += quantity_section(table, *quantity);
  body += html::section("All metrics", all_quantities(table));
  if (const Quantity* quantity = worst_by(table, informative)) body += worst_section(table, *quantity, directory);
  body += failure_section(table) + timing_section(table);
  body += html::section("Batch file, with every default",
                        html::folded(table.info.file, "<pre>" + escape_markup(table.info.text) + "</pre>"));
  return html::page(table.info.name, body);
}

std::string batch_report_csv(const BatchTable& table) {
  std::string text = "point,variant";
  for (const std::string& name : table.info.parameters) text += "," + csv_cell(name);
  text +=
      ",metric,vehicle,n,mean,sd,ci_low,ci_high,min,q1,median,q3,max,pairs,difference,difference_sd,difference_ci_low,"
      "difference_ci_high\n";
  std::vector<const EpisodeGroup*> groups;
  for (const auto* list : {&table.groups, &table.totals}) {
    for (const EpisodeGroup& group : *list) groups.push_back(&group);
  }
  for (const EpisodeGroup* at : groups) {
    const EpisodeGroup& group = *at;
    const std::string head = csv_head(group, table.info.parameters.size());
    const EpisodeGroup* reference = table.reference_of(group);
    const std::uint64_t done = count_done(table, group);
    for (const std::string& outcome : table.outcomes) {
      const std::uint64_t count = count_outcome(table, outcome, group);
      const Interval ci = rate_interval(table, outcome, group);
      text += head + "," + csv_cell("outcome = " + outcome) + ",," + std::to_string(done) + "," +
              csv_cell(done > 0 ? static_cast<double>(count) / static_cast<double>(done) : std::nan("")) + ",," +
              csv_cell(ci.low) + "," + csv_cell(ci.high) + ",,,,,";
      if (reference != nullptr) {
        const PairedCounts counts = paired_outcomes(table, outcome, *reference, group);
        const RateDifference d = paired_rate_difference(counts);
        text += "," + std::to_string(counts.both + counts.first_only + counts.second_only + counts.neither) + "," +
                csv_cell(d.difference) + ",," + csv_cell(d.ci.low) + "," + csv_cell(d.ci.high) + "\n";
      } else {
        text += ",,,,,\n";
      }
    }
    for (const Quantity& quantity : table.quantities) {
      const SampleSummary s = summary_of(table, quantity, group);
      text += head + "," + csv_cell(quantity.metric) + "," + csv_cell(quantity.vehicle) + "," + std::to_string(s.n);
      for (const double x : {s.mean, s.sd, s.mean_ci.low, s.mean_ci.high, s.min, s.q1, s.median, s.q3, s.max})
        text += "," + csv_cell(x);
      if (reference != nullptr) {
        const PairedValues pairs = paired_values(table, quantity, *reference, group);
        const SampleSummary d = paired_difference(pairs.first, pairs.second, pairs.seeds);
        text += "," + std::to_string(d.n);
        for (const double x : {d.mean, d.sd, d.mean_ci.low, d.mean_ci.high}) text += "," + csv_cell(x);
        text += "\n";
      } else {
        text += ",,,,,\n";
      }
    }
  }
  return text;
}

std::vector<fs::path> write_batch_report(const fs::path& directory) {
  const fs::path database = directory / "results.sqlite";
  if (!fs::is_regular_file(database)) {
    const bool shards = fs::is_directory(directory / "shards");
    throw InputError(directory.string() + ": expected a batch directory with results.sqlite, found none" +
                     (shards ? "; merge its shards first: swiftlet batch merge --out " + directory.string() : ""));
  }
  const BatchTable table = read_batch_table(ResultStore(database, ResultStore::Mode::kRead));
  write_file(directory / "report.html", batch_report_html(table, directory));
  write_file(directory / "report.csv", batch_report_csv(table));
  return {directory / "report.html", directory / "report.csv"};
}

}  // namespace swiftlet::sim

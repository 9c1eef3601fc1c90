// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/report/batch_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "sim/report/group_samples.hpp"
#include "sim/report/html.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::sim {
namespace {

// [-] Quantities that are plotted if the batch file names none.
constexpr std::size_t kMaxColumns = 6;
constexpr const char* kMean = "mean";
const double kNaN = std::nan("");

/// The batch file stored in the database.
BatchConfig config_of(const BatchInfo& info, const std::filesystem::path& database) {
  BatchConfig config;
  try {
    read_config_text(info.text, info.file, [&](ConfigVisitor& v) { config.visit(v); });
  } catch (const InputError& problem) {
    throw InputError(database.string() + ": batch.text: expected a batch file, found a mistake: " + problem.what());
  }
  return config;
}

/// Collects metrics as columns, in the order of their first appearance.
class Columns {
 public:
  explicit Columns(std::size_t num_episodes) : num_episodes_(num_episodes) {}

  void add(std::size_t episode, const std::vector<MetricRow>& metrics) {
    std::map<std::string, std::pair<double, int>> sums;  // over vehicles
    std::vector<std::string> order;
    for (const MetricRow& row : metrics) {
      if (!row.text.empty()) continue;
      set(row.name, row.vehicle, episode, row.value);
      if (row.vehicle.empty()) continue;
      auto [sum, fresh] = sums.try_emplace(row.name, 0.0, 0);
      if (fresh) order.push_back(row.name);
      if (std::isnan(row.value)) continue;
      sum->second.first += row.value;
      ++sum->second.second;
    }
    for (const std::string& name : order) {
      const auto& [sum, count] = sums.at(name);
      set(name, kMean, episode, count > 0 ? sum / count : kNaN);
    }
  }

  /// Omits quantities without any value, and means over a single vehicle.
  std::vector<Quantity> take() {
    std::map<std::string, std::set<std::string>> vehicles;
    for (const Quantity& q : quantities_) vehicles[q.metric].insert(q.vehicle);
    std::vector<Quantity> kept;
    for (Quantity& q : quantities_) {
      const bool measured = std::any_of(q.values.begin(), q.values.end(), [](double x) { return std::isfinite(x); });
      const bool repeats = q.vehicle == kMean && vehicles.at(q.metric).size() == 2;
      if (measured && !repeats) kept.push_back(std::move(q));
    }
    return kept;
  }

 private:
  void set(const std::string& metric, const std::string& vehicle, std::size_t episode, double value) {
    const auto [at, fresh] = index_.emplace(std::pair(metric, vehicle), quantities_.size());
    if (fresh) quantities_.push_back({metric, vehicle, std::vector<double>(num_episodes_, kNaN)});
    quantities_[at->second].values[episode] = value;
  }

  std::size_t num_episodes_;
  std::vector<Quantity> quantities_;
  std::map<std::pair<std::string, std::string>, std::size_t> index_;
};

std::vector<EpisodeGroup> groups_of(const BatchTable& table) {
  std::map<std::pair<std::size_t, std::size_t>, EpisodeGroup> groups;
  for (std::size_t i = 0; i < table.episodes.size(); ++i) {
    const EpisodeRow& row = table.episodes[i];
    const auto& variants = table.info.variants;
    const auto variant =
        static_cast<std::size_t>(std::find(variants.begin(), variants.end(), row.variant) - variants.begin());
    EpisodeGroup& group = groups[{row.point, variant}];
    group.point = row.point;
    group.variant = row.variant;
    group.parameters = row.parameters;
    group.episodes.push_back(i);
  }
  std::vector<EpisodeGroup> list;
  for (auto& [key, group] : groups) {
    std::sort(group.episodes.begin(), group.episodes.end(),
              [&](std::size_t a, std::size_t b) { return table.episodes[a].seed < table.episodes[b].seed; });
    list.push_back(std::move(group));
  }
  return list;
}

/// Groups over all points, one per variant.
std::vector<EpisodeGroup> totals_of(const BatchTable& table) {
  std::vector<EpisodeGroup> totals;
  for (const std::string& variant : table.info.variants) {
    EpisodeGroup total{EpisodeGroup::kAllPoints, variant, {}, {}};
    std::size_t num_groups = 0;
    for (const EpisodeGroup& group : table.groups) {
      if (group.variant != variant) continue;
      ++num_groups;
      total.episodes.insert(total.episodes.end(), group.episodes.begin(), group.episodes.end());
    }
    if (num_groups > 1) totals.push_back(std::move(total));
  }
  return totals;
}

/// Calls `use(a, b)` for episodes of two groups with equal point and seed.
template <class Use>
void for_each_pair(const BatchTable& table, const EpisodeGroup& first, const EpisodeGroup& second, const Use& use) {
  const auto place = [&](std::size_t i) { return std::pair(table.episodes[i].point, table.episodes[i].seed); };
  auto b = second.episodes.begin();
  for (const std::size_t a : first.episodes) {
    while (b != second.episodes.end() && place(*b) < place(a)) ++b;
    if (b == second.episodes.end()) return;
    if (place(*b) == place(a)) use(a, *b);
  }
}

/// A swept value for display: numbers with four digits.
std::string shown(const std::string& value) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || value.size() <= 6) return value;
  return html::number(number);
}

/// Share of the variance between the groups; with one group, the relative variation.
double informativeness(const BatchTable& table, const Quantity& quantity) {
  const SampleSummary all = summarize(quantity.values);
  if (all.n < 2 || !(all.sd > 1e-9 * std::abs(all.mean))) return 0.0;
  if (table.groups.size() < 2) return all.mean != 0.0 ? std::min(1.0, all.sd / std::abs(all.mean)) : 1.0;
  double between = 0.0, within = 0.0;
  for (const EpisodeGroup& group : table.groups) {
    const SampleSummary own = summarize(values_of(quantity, group));
    if (own.n == 0) continue;
    const auto n = static_cast<double>(own.n);
    between += n * (own.mean - all.mean) * (own.mean - all.mean);
    within += own.n > 1 ? (n - 1.0) * own.sd * own.sd : 0.0;
  }
  return between / (between + within);
}

std::vector<const Quantity*> named_quantities(const BatchTable& table) {
  std::vector<const Quantity*> chosen;
  for (const std::string& name : table.config.report.metrics) {
    const std::size_t before = chosen.size();
    for (const char* vehicle : {"", kMean}) {
      if (const Quantity* q = table.find(name, vehicle)) chosen.push_back(q);
    }
    for (const Quantity& q : table.quantities) {
      const bool is_only = chosen.size() == before && q.metric == name;
      if (is_only || q.vehicle + "." + q.metric == name) chosen.push_back(&q);
    }
  }
  return chosen;
}

}  // namespace

const Quantity* BatchTable::find(const std::string& metric, const std::string& vehicle) const {
  for (const Quantity& q : quantities) {
    if (q.metric == metric && q.vehicle == vehicle) return &q;
  }
  return nullptr;
}

const EpisodeGroup* BatchTable::reference_of(const EpisodeGroup& group) const {
  if (info.variants.empty() || group.variant == info.variants.front()) return nullptr;
  for (const EpisodeGroup& other : group.point == EpisodeGroup::kAllPoints ? totals : groups) {
    if (other.point == group.point && other.variant == info.variants.front()) return &other;
  }
  return nullptr;
}

std::string BatchTable::point_name(const EpisodeGroup& group) const {
  if (group.point == EpisodeGroup::kAllPoints) return "all points";
  std::string name;
  for (std::size_t i = 0; i < group.parameters.size(); ++i) {
    name += (name.empty() ? "" : ", ") + info.parameters[i] + " " + shown(group.parameters[i]);
  }
  return name;
}

std::string BatchTable::name_of(const EpisodeGroup& group) const {
  std::string name = point_name(group);
  if (info.variants.size() > 1) name += (name.empty() ? "" : ", ") + group.variant;
  return name.empty() ? info.name : name;
}

BatchTable read_batch_table(const ResultStore& store) {
  BatchTable table;
  const auto info = store.info();
  if (!info) throw InputError(store.file().string() + ": expected results of a batch, found a database without any");
  table.info = *info;
  table.config = config_of(*info, store.file());
  table.episodes = store.episodes();
  Columns columns(table.episodes.size());
  std::set<std::string> outcomes;
  for (std::size_t i = 0; i < table.episodes.size(); ++i) {
    EpisodeRow& row = table.episodes[i];
    columns.add(i, row.metrics);
    row.metrics.clear();
    if (row.done()) outcomes.insert(row.outcome);
  }
  table.quantities = columns.take();
  table.outcomes.assign(outcomes.begin(), outcomes.end());
  table.groups = groups_of(table);
  table.totals = totals_of(table);
  return table;
}

std::vector<double> values_of(const Quantity& quantity, const EpisodeGroup& group) {
  std::vector<double> values;
  for (const std::size_t i : group.episodes) values.push_back(quantity.values[i]);
  return values;
}

std::vector<std::uint64_t> seeds_of(const BatchTable& table, const EpisodeGroup& group) {
  std::vector<std::uint64_t> seeds;
  for (const std::size_t i : group.episodes) seeds.push_back(table.episodes[i].seed);
  return seeds;
}

std::vector<double> outcomes_of(const BatchTable& table, const std::string& outcome, const EpisodeGroup& group) {
  std::vector<double> values;
  for (const std::size_t i : group.episodes) {
    const EpisodeRow& row = table.episodes[i];
    values.push_back(!row.done() ? kNaN : row.outcome == outcome ? 1.0 : 0.0);
  }
  return values;
}

PairedValues paired_values(const BatchTable& table, const Quantity& quantity, const EpisodeGroup& first,
                           const EpisodeGroup& second) {
  PairedValues values;
  for_each_pair(table, first, second, [&](std::size_t a, std::size_t b) {
    values.first.push_back(quantity.values[a]);
    values.second.push_back(quantity.values[b]);
    values.seeds.push_back(table.episodes[a].seed);
  });
  return values;
}

PairedCounts paired_outcomes(const BatchTable& table, const std::string& outcome, const EpisodeGroup& first,
                             const EpisodeGroup& second) {
  PairedCounts counts;
  std::vector<double> differences;
  std::vector<std::uint64_t> seeds;
  for_each_pair(table, first, second, [&](std::size_t a, std::size_t b) {
    const EpisodeRow &x = table.episodes[a], &y = table.episodes[b];
    if (!x.done() || !y.done()) return;
    const bool in_first = x.outcome == outcome, in_second = y.outcome == outcome;
    ++(in_first ? (in_second ? counts.both : counts.first_only) : (in_second ? counts.second_only : counts.neither));
    differences.push_back(static_cast<double>(in_second) - static_cast<double>(in_first));
    seeds.push_back(x.seed);
  });
  counts.independent = independent_share(differences, seeds);
  return counts;
}

std::uint64_t count_outcome(const BatchTable& table, const std::string& outcome, const EpisodeGroup& group) {
  return static_cast<std::uint64_t>(std::count_if(group.episodes.begin(), group.episodes.end(), [&](std::size_t i) {
    return table.episodes[i].done() && table.episodes[i].outcome == outcome;
  }));
}

std::vector<const Quantity*> informative_quantities(const BatchTable& table) {
  if (!table.config.report.metrics.empty()) return named_quantities(table);
  std::vector<std::pair<double, const Quantity*>> ranked;
  for (const Quantity& quantity : table.quantities) {
    const bool is_one_of_many =
        !quantity.vehicle.empty() && quantity.vehicle != kMean && table.find(quantity.metric, kMean) != nullptr;
    if (!is_one_of_many) ranked.emplace_back(informativeness(table, quantity), &quantity);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<const Quantity*> chosen;
  for (const auto& [share, quantity] : ranked) {
    if (chosen.size() < kMaxColumns && share > 0.0) chosen.push_back(quantity);
  }
  return chosen;
}

}  // namespace swiftlet::sim

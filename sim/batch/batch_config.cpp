// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/batch_config.hpp"

#include <algorithm>
#include <charconv>

#include "swiftlet/sim/metrics/metrics.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::sim {
namespace {

// [-] Maximum number of variants of a batch; larger lists are refused.
constexpr std::size_t kMaxVariants = 1000;

bool is_word(const std::string& text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  });
}

/// True for a text that is valid within one line of a job script.
bool is_line(const std::string& text) {
  return std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
}

/// A list of names in Slurm's format: a,b.
bool is_slurm_name(const std::string& text) {
  return text.empty() || std::all_of(text.begin(), text.end(), [](char c) { return c == ',' || is_word({c}); });
}

bool is_seed(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && value >= 0;
}

std::string last_word(const std::string& key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string::npos ? key : key.substr(dot + 1);
}

std::string element(const char* list, std::size_t index, const char* key) {
  return std::string(list) + "[" + std::to_string(index) + "]." + key;
}

}  // namespace

void VariantConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] unique name of the variant");
  v.field(
      "scenario", scenario,
      "[-] file or name of the scenario of the variant, normally one with `base:`; empty: the scenario of the batch");
  v.changes("set", set, "[-] changes to the scenario");
}

void ParameterConfig::visit(ConfigVisitor& v) {
  v.field("key", key, "[-] key of the scenario: world.stems_per_ha, vehicles[*].agent.guidance.speed_mps, ...");
  v.field("name", name, "[-] name of the column in the results; empty: the last word of the key");
  v.choice("law", law, kLaws, "[-] source of the values: the list, or a distribution");
  v.field("values", values, "[-] law values: the list, from which samples are drawn with equal probability");
  v.field("min", min, "[-] uniform, log_uniform, integer: smallest value, in the unit of the key");
  v.field("max", max, "[-] uniform, log_uniform, integer: largest value");
  v.field("mean", mean, "[-] normal: mean, in the unit of the key");
  v.field("sd", sd, "[-] normal: standard deviation before truncation", Range::positive());
  v.field("cut_sd", cut_sd, "[-] normal: truncated at mean -+ cut_sd * sd", Range{0.0, 8.0, true});
  v.field("steps", steps, "[-] grid, list: number of evenly spaced values of a uniform, log_uniform or integer law",
          Range::between(1, 100'000));
  v.check(!key.empty(), "key", "the key that is swept");
  v.check(law != ParameterConfig::Law::kValues || !values.empty(), "values", "at least one value");
  v.check(law == ParameterConfig::Law::kValues || values.empty(), "values",
          "no values with law \"" + std::string(kLaws[static_cast<std::size_t>(law)]) + "\"");
  v.check(law == ParameterConfig::Law::kValues || law == ParameterConfig::Law::kNormal || min < max ||
              (law == ParameterConfig::Law::kInteger && min == max),
          "max", "more than min");
  v.check(law != ParameterConfig::Law::kLogUniform || min > 0.0, "min", "more than 0 for law \"log_uniform\"");
  if (name.empty()) name = last_word(key);
}

void SweepConfig::visit(ConfigVisitor& v) {
  v.choice("method", method, {"grid", "list", "latin_hypercube", "random"},
           "[-] all combinations; i-th values of all lists; stratified or independent samples of the laws");
  v.field("samples", samples, "[-] latin_hypercube, random: number of points", Range::between(1, 1'000'000));
  v.field("seed", seed, "[-] latin_hypercube, random: seed of the sampling");
  v.list("parameters", parameters, "swept parameters; none: a single point");
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const bool sampled = method == SweepConfig::Method::kLatinHypercube || method == SweepConfig::Method::kRandom;
    v.check(sampled || parameters[i].law != ParameterConfig::Law::kNormal, element("parameters", i, "law").c_str(),
            "another law than \"normal\" with method \"grid\" or \"list\"");
    for (std::size_t j = 0; j < i; ++j) {
      v.check(parameters[i].name != parameters[j].name, element("parameters", i, "name").c_str(),
              "a name that is not taken yet");
    }
  }
}

void SeedsConfig::visit(ConfigVisitor& v) {
  v.field("first", first, "[-] first seed; the others follow by steps of 1");
  v.field("count", count, "[-] number of seeds", Range::between(1, 10'000'000));
  v.field("list", list, "[-] explicit list of seeds, instead of first and count");
  v.choice("pairing", pairing, kPairings, "[-] every point of the sweep with every seed; or point i with seed i alone");
  for (std::size_t i = 0; i < list.size(); ++i) {
    v.check(is_seed(list[i]), ("list[" + std::to_string(i) + "]").c_str(), "a whole number in [0, 2^63)");
  }
  v.check(first < (1ULL << 62), "first", "a whole number in [0, 2^62)");
}

void SlurmConfig::visit(ConfigVisitor& v) {
  v.field("partition", partition, "[-] partition of the cluster; empty: the default");
  v.field("account", account, "[-] account of the job; empty: the default of the user");
  v.field("episodes_per_task", episodes_per_task, "[-] episodes per array task; 0: 20 for each of its processors",
          Range::non_negative());
  v.field("cpus_per_task", cpus_per_task, "[-] worker processes of a task", Range::between(1, 4096));
  v.field("max_running_tasks", max_running_tasks, "[-] largest number of concurrent tasks; 0: no limit",
          Range::non_negative());
  v.field("memory_per_cpu_mb", memory_per_cpu_mb, "[MiB] requested memory, of which workers may use 90 %",
          Range::positive());
  v.field("time_limit_min", time_limit_min,
          "[min] time limit of one task; 0: sufficient if each episode takes timeout_s", Range::non_negative());
  v.field("options", options, "[-] further options of sbatch, such as --constraint=avx2");
  v.check(is_slurm_name(partition), "partition", "names of letters, digits, '_', '-' and '.', separated by commas");
  v.check(is_slurm_name(account), "account", "names of letters, digits, '_', '-' and '.', separated by commas");
  for (std::size_t i = 0; i < options.size(); ++i) {
    v.check(options[i].starts_with('-') && is_line(options[i]), ("options[" + std::to_string(i) + "]").c_str(),
            "an option of sbatch in one line, beginning with '-'");
  }
}

void ReportConfig::visit(ConfigVisitor& v) {
  v.field("metrics", metrics, "[-] metrics shown with plots; none: chosen by their variance between groups");
  v.field("worst_by", worst_by, "[-] metric by which the worst episodes are chosen; empty: the first of the metrics");
  v.choice("worst_is", worst_is, {"high", "low"}, "[-] whether high or low values of that metric are worst");
}

void BatchConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the batch");
  v.field("description", description, "[-] one sentence about the batch");
  v.field("scenario", scenario, "[-] file (relative to this one) or name of a scenario");
  v.changes("set", set, "[-] changes to the scenario, for every episode");
  v.list("variants", variants, "compared settings, the first is the reference; none: the unchanged scenario");
  v.object("sweep", sweep, "swept parameters and the choice of points");
  v.object("seeds", seeds, "random seeds of the episodes, combined with the points by pairing");
  v.field("threads", threads, "[-] threads per episode; more workers (--jobs) speed up a batch better",
          Range::between(1, 1024));
  v.field("timeout_s", timeout_s,
          "[s] wall time limit of one episode, beyond which it is recorded as timed_out; 0: none",
          Range::non_negative());
  v.field("memory_limit_mb", memory_limit_mb,
          "[MiB] limit of one worker, beyond which an episode is recorded as out_of_memory; 0: none",
          Range::non_negative());
  v.field("episodes_per_worker", episodes_per_worker,
          "[-] number of episodes after which a worker process is replaced; 0: never", Range::non_negative());
  v.object("slurm", slurm, "resources requested from a Slurm cluster");
  v.object("report", report, "content of the report");

  v.check(is_word(name), "name", "a word of letters, digits, '_', '-' and '.'");
  bool has_scenario = !variants.empty();
  for (const VariantConfig& variant : variants) has_scenario = has_scenario && !variant.scenario.empty();
  v.check(!scenario.empty() || has_scenario, "scenario", "the scenario that is flown");
  v.check(variants.size() <= kMaxVariants, "variants", "at most " + std::to_string(kMaxVariants) + " variants");
  for (std::size_t i = 0; i < variants.size(); ++i) {
    v.check(is_word(variants[i].name), element("variants", i, "name").c_str(),
            "a word of letters, digits, '_', '-' and '.'");
    for (std::size_t j = 0; j < i; ++j) {
      v.check(variants[i].name != variants[j].name, element("variants", i, "name").c_str(),
              "a name that is not taken yet");
    }
  }
}

namespace {

/// Accepts a metric, or the metric of one vehicle: "min_separation_m", "uav1.min_separation_m".
void check_metric(ConfigVisitor& v, const std::string& name, const std::vector<std::string>& known,
                  const std::string& key) {
  const std::string metric = name.substr(name.rfind('.') + 1);
  if (name.empty() || std::find(known.begin(), known.end(), metric) != known.end()) return;
  v.check(false, key.c_str(), "a metric (swiftlet list metrics)" + did_you_mean(metric, known));
}

// Skipped when a finished batch is read, since a program with additional metrics may have flown it.
void check_metrics(ConfigVisitor& v, const ReportConfig& report) {
  const std::optional<std::vector<std::string>> known = metric_names();
  if (!known) return;
  for (std::size_t i = 0; i < report.metrics.size(); ++i)
    check_metric(v, report.metrics[i], *known, "report.metrics[" + std::to_string(i) + "]");
  check_metric(v, report.worst_by, *known, "report.worst_by");
}

}  // namespace

BatchConfig load_batch_config(const std::filesystem::path& file, const ConfigChanges& overrides) {
  BatchConfig config;
  read_config(
      file,
      [&](ConfigVisitor& v) {
        config.visit(v);
        check_metrics(v, config.report);
      },
      overrides);
  return config;
}

}  // namespace swiftlet::sim

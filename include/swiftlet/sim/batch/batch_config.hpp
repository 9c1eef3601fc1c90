// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"

/// The batch file: its variants, parameter sweep, seeds and execution limits.
namespace swiftlet::sim {

/// One of the settings that a batch compares. Variants share the seeds and therefore all random numbers that both draw.
struct VariantConfig {
  std::string name;
  std::string scenario;  ///< empty: the batch's scenario
  ConfigChanges set;

  void visit(ConfigVisitor& v);
};

/// One swept key of the scenario.
struct ParameterConfig {
  std::string key;
  std::string name;                 ///< column name in results; empty: the last part of the key
  std::vector<std::string> values;  ///< law kValues: the list or grid values, or choices of equal probability
  enum class Law { kValues, kUniform, kLogUniform, kNormal, kInteger };
  static constexpr const char* kLaws[] = {"values", "uniform", "log_uniform", "normal", "integer"};
  Law law = Law::kValues;
  double min = 0.0, max = 1.0;
  double mean = 0.0, sd = 1.0, cut_sd = 4.0;
  int steps = 5;

  void visit(ConfigVisitor& v);
};

struct SweepConfig {
  enum class Method { kGrid, kList, kLatinHypercube, kRandom };
  Method method = Method::kGrid;
  int samples = 10;
  std::uint64_t seed = 1;
  std::vector<ParameterConfig> parameters;

  void visit(ConfigVisitor& v);
};

struct SeedsConfig {
  std::uint64_t first = 1;
  int count = 10;
  std::vector<std::string> list;
  enum class Pairing { kCross, kZip };
  static constexpr const char* kPairings[] = {"cross", "zip"};
  Pairing pairing = Pairing::kCross;

  void visit(ConfigVisitor& v);
};

/// Resources requested from a Slurm cluster (`swiftlet batch --slurm`).
struct SlurmConfig {
  std::string partition;
  std::string account;
  int episodes_per_task = 0;
  int cpus_per_task = 1;
  int max_running_tasks = 0;
  double memory_per_cpu_mb = 2000.0;
  double time_limit_min = 0.0;
  std::vector<std::string> options;

  void visit(ConfigVisitor& v);
};

struct ReportConfig {
  std::vector<std::string> metrics;
  std::string worst_by;
  enum class WorstIs { kHigh, kLow };
  WorstIs worst_is = WorstIs::kHigh;

  void visit(ConfigVisitor& v);
};

struct BatchConfig {
  std::string name = "batch";
  std::string description;
  std::string scenario;
  ConfigChanges set;
  std::vector<VariantConfig> variants;
  SweepConfig sweep;
  SeedsConfig seeds;
  int threads = 1;
  double timeout_s = 3600.0;
  double memory_limit_mb = 0.0;
  int episodes_per_worker = 0;
  SlurmConfig slurm;
  ReportConfig report;

  void visit(ConfigVisitor& v);
};

/// Reads a batch file, by path or by the name of one that comes with Swiftlet ("batch/forest_gains"). Throws
/// InputError.
BatchConfig load_batch_config(const std::filesystem::path& file, const ConfigChanges& overrides = {});

}  // namespace swiftlet::sim

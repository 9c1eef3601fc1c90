// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/shard.hpp"

#include <charconv>
#include <cstdint>
#include <cstdlib>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

// [-] Maximum number of shards of a batch; larger numbers are refused.
constexpr std::int64_t kMaxShards = 10'000'000;

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Value of an environment variable; nothing if it is not set. Throws InputError unless it is a whole number.
std::optional<int> number(const Environment& environment, const std::string& name) {
  const auto text = environment(name);
  if (!text) return std::nullopt;
  const auto value = whole_number(*text);
  if (!value) throw InputError(name + ": expected a whole number, found \"" + *text + "\"");
  return value;
}

/// Value of an environment variable that must be set because the variable `with` is.
int need(const Environment& environment, const std::string& name, const std::string& with) {
  const auto value = number(environment, name);
  if (!value)
    throw InputError(name + ": expected a whole number, because " + with +
                     " is set, found nothing; set --shard i/n instead");
  return *value;
}

Shard checked(std::int64_t index, std::int64_t count, const std::string& source) {
  if (count < 1 || count > kMaxShards || index < 0 || index >= count) {
    throw InputError(source + ": expected an index, counted from 0, below the number of shards, at most " +
                     std::to_string(kMaxShards) + ", found index " + std::to_string(index) + " of " +
                     std::to_string(count) + " shards");
  }
  return {static_cast<int>(index), static_cast<int>(count), source};
}

/// Shard of a task in a Slurm job array.
Shard slurm_array(const Environment& environment) {
  const std::int64_t id = need(environment, "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT");
  const std::int64_t count = need(environment, "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_ID");
  const std::int64_t min = number(environment, "SLURM_ARRAY_TASK_MIN").value_or(0);
  const auto last = number(environment, "SLURM_ARRAY_TASK_MAX");
  const std::int64_t max = last ? *last : min + count - 1;
  const std::int64_t step = count > 1 ? (max - min) / (count - 1) : 1;
  // In an array with gaps, a task does not determine the index of a shard. A single task with a number above 1 was
  // resubmitted from a larger array, whose size is unknown.
  if (step < 1 || min + step * (count - 1) != max || (id - min) % step != 0 || (count == 1 && id > 1)) {
    throw InputError("SLURM_ARRAY_TASK_ID: expected a complete job array with a fixed step, found " +
                     (count == 1 ? "task " + std::to_string(id) + " alone" : std::string("an array with gaps")) +
                     "; set --shard i/n instead");
  }
  return checked((id - min) / step, count, "SLURM_ARRAY_TASK_ID");
}

/// Shard of an element of a Slurm array or of an indexed Kubernetes job; the whole batch without either.
Shard outer_shard(const Environment& environment) {
  if (environment("SLURM_ARRAY_TASK_ID")) return slurm_array(environment);
  if (const auto index = number(environment, "JOB_COMPLETION_INDEX")) {
    return checked(*index, need(environment, "SWIFTLET_NUM_SHARDS", "JOB_COMPLETION_INDEX"), "JOB_COMPLETION_INDEX");
  }
  return {};
}

/// Shard of an MPI or Slurm rank within that element; the whole without ranks.
Shard rank(const Environment& environment) {
  constexpr const char* kRanks[][2] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                       {"PMI_RANK", "PMI_SIZE"},
                                       {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}};
  for (const auto& [index, count] : kRanks) {
    // Slurm sets SLURM_PROCID in batch scripts too, but SLURM_STEP_NUM_TASKS only in job steps.
    if (environment(index) && (environment(count) || std::string(index) != "SLURM_PROCID")) {
      return checked(*number(environment, index), need(environment, count, index), index);
    }
  }
  return {};
}

}  // namespace

Environment system_environment() {
  return [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    return value == nullptr || *value == '\0' ? std::nullopt : std::optional<std::string>(value);
  };
}

Shard parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto index = slash == std::string::npos ? std::nullopt : whole_number(std::string_view(text).substr(0, slash));
  const auto count = slash == std::string::npos ? std::nullopt : whole_number(std::string_view(text).substr(slash + 1));
  if (!index || !count || *index < 1 || *count < *index || *count > kMaxShards) {
    throw InputError("--shard: expected i/n with 1 <= i <= n, such as 2/8, found \"" + text + "\"");
  }
  return {*index - 1, *count, "--shard"};
}

Shard shard_of_environment(const Environment& environment) {
  const Shard outer = outer_shard(environment);
  const Shard inner = rank(environment);
  std::string source = outer.source;
  if (!inner.whole()) source += (source.empty() ? "" : ", ") + inner.source;
  return checked(std::int64_t{outer.index} * inner.count + inner.index, std::int64_t{outer.count} * inner.count,
                 source);
}

}  // namespace swiftlet::sim

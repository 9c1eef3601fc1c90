// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/slurm.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <string_view>

#include "embedded/sim_batch.hpp"
#include "swiftlet/sim/batch/shell.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxTasks = 1000;  // Slurm's default MaxArraySize is 1001
// [-] Episodes per worker of a task without a configured number. Larger values start fewer tasks and lose more by a
// failure.
constexpr int kEpisodesPerCpu = 20;
// [min] Time of a task for its start, in its time limit.
constexpr double kStartUp_min = 5.0;
constexpr int kDay_min = 24 * 60;
// Share of a task's memory for a worker's limit, so that the limit acts before Slurm kills the task
constexpr double kMemoryMargin = 0.9;

/// The template with the value of NAME in place of each @NAME@. Any other @ stays.
std::string filled(std::string_view text, const std::map<std::string_view, std::string>& values) {
  std::string result;
  while (!text.empty()) {
    const std::size_t begin = text.find('@');
    result += text.substr(0, begin);
    if (begin == std::string_view::npos) break;
    text.remove_prefix(begin + 1);
    const std::size_t end = text.find('@');
    const auto value = end == std::string_view::npos ? values.end() : values.find(text.substr(0, end));
    if (value == values.end()) {
      result += '@';
    } else {
      result += value->second;
      text.remove_prefix(end + 1);
    }
  }
  return result;
}

std::string option(const std::string& name, const std::string& value) {
  return "#SBATCH --" + name + "=" + value + "\n";
}

std::string account(const SlurmConfig& config) {
  std::string text;
  if (!config.partition.empty()) text += option("partition", config.partition);
  if (!config.account.empty()) text += option("account", config.account);
  return text;
}

std::string further(const SlurmConfig& config) {
  std::string text;
  for (const std::string& line : config.options) text += "#SBATCH " + line + "\n";
  return text;
}

/// Rounded up; limited to the digits of Slurm's largest time limit.
int whole_minutes(double minutes) { return static_cast<int>(std::ceil(std::min(minutes, 1e9))); }

int task_minutes(const BatchConfig& config, int episodes_per_task) {
  if (config.slurm.time_limit_min > 0.0) return whole_minutes(config.slurm.time_limit_min);
  if (config.timeout_s <= 0.0) return kDay_min;
  const double rounds = std::ceil(static_cast<double>(episodes_per_task) / config.slurm.cpus_per_task);
  return whole_minutes(rounds * config.timeout_s / 60.0 + kStartUp_min);
}

std::string array_script(const BatchPlan& plan, const SlurmScripts& job, const fs::path& out, const fs::path& program) {
  const BatchConfig& config = plan.config();
  const SlurmConfig& slurm = config.slurm;
  const double worker_mb = slurm.memory_per_cpu_mb * kMemoryMargin;
  const bool limit = config.memory_limit_mb <= 0.0 || config.memory_limit_mb > worker_mb;
  const std::string running = slurm.max_running_tasks > 0 ? "%" + std::to_string(slurm.max_running_tasks) : "";
  return filled(embedded::slurm_array_sh,
                {{"account", account(slurm)},
                 {"range", "1-" + std::to_string(job.num_tasks) + running},
                 {"cpus", std::to_string(slurm.cpus_per_task)},
                 {"memory_mb", std::to_string(static_cast<int>(std::ceil(slurm.memory_per_cpu_mb)))},
                 {"minutes", std::to_string(job.time_limit_min)},
                 {"options", further(slurm)},
                 {"tasks", std::to_string(job.num_tasks)},
                 {"memory_limit", limit ? " --memory-limit " + std::to_string(static_cast<int>(worker_mb)) : ""},
                 {"name", config.name},
                 {"log", in_shell_quotes((out / "slurm" / "%A_%a.log").string())},
                 {"program", in_shell_quotes(program.string())},
                 {"file", in_shell_quotes(plan.file().string())},
                 {"out", in_shell_quotes(out.string())}});
}

std::string merge_script(const BatchPlan& plan, const fs::path& out, const fs::path& program) {
  return filled(embedded::slurm_merge_sh, {{"account", account(plan.config().slurm)},
                                           {"name", plan.config().name},
                                           {"log", in_shell_quotes((out / "slurm" / "merge_%j.log").string())},
                                           {"program", in_shell_quotes(program.string())},
                                           {"out", in_shell_quotes(out.string())}});
}

std::string sbatch(const std::string& arguments) {
  const std::string command = "sbatch --parsable " + arguments + " 2>&1";
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot start sbatch");
  std::string output;
  std::array<char, 256> buffer;
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) output += buffer.data();
  const int status = ::pclose(pipe);
  while (!output.empty() && output.back() == '\n') output.pop_back();
  if (status != 0) {
    throw std::runtime_error("sbatch ended with status " +
                             std::to_string(WIFEXITED(status) ? WEXITSTATUS(status) : -1) + ": " + output);
  }
  return output.substr(0, output.find(';'));  // "job;cluster"
}

}  // namespace

SlurmScripts make_slurm_scripts(const BatchPlan& plan, const fs::path& out, const fs::path& program) {
  const SlurmConfig& config = plan.config().slurm;
  const auto episodes = static_cast<double>(plan.num_episodes());
  SlurmScripts job;
  job.episodes_per_task =
      config.episodes_per_task > 0 ? config.episodes_per_task : kEpisodesPerCpu * config.cpus_per_task;
  job.num_tasks = static_cast<int>(std::clamp(std::ceil(episodes / job.episodes_per_task), 1.0, double{kMaxTasks}));
  job.episodes_per_task = static_cast<int>(std::ceil(episodes / job.num_tasks));
  job.time_limit_min = task_minutes(plan.config(), job.episodes_per_task);
  const fs::path directory = fs::absolute(out).lexically_normal();
  const std::string& name = directory.native();
  if (std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }))
    throw InputError("--out: expected a directory whose name is one line of a job script, found control characters");
  job.array = array_script(plan, job, directory, program);
  job.merge = merge_script(plan, directory, program);
  return job;
}

SlurmFiles write_slurm_scripts(const SlurmScripts& scripts, const fs::path& out) {
  const fs::path folder = fs::absolute(out).lexically_normal() / "slurm";
  make_directory(out);
  make_inner_directory(folder);
  const SlurmFiles files{folder / "array.sbatch", folder / "merge.sbatch"};
  write_file(files.array, scripts.array);
  write_file(files.merge, scripts.merge);
  return files;
}

SlurmJobs submit(const SlurmFiles& files) {
  SlurmJobs jobs;
  jobs.array = sbatch(in_shell_quotes(files.array.string()));
  jobs.merge = sbatch("--dependency=afterany:" + jobs.array + " " + in_shell_quotes(files.merge.string()));
  return jobs;
}

}  // namespace swiftlet::sim

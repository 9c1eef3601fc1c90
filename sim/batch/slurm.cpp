// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/slurm.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "swiftlet/sim/batch/shell.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxTasks = 1000;  // Slurm's default MaxArraySize is 1001
constexpr int kEpisodesPerCpu = 20;
constexpr double kStartUp_min = 5.0;
constexpr int kDay_min = 24 * 60;
// Share of a task's memory for a worker's limit, so that the limit acts before Slurm kills the task
constexpr double kMemoryMargin = 0.9;

std::string option(const std::string& name, const std::string& value) {
  return "#SBATCH --" + name + "=" + value + "\n";
}

std::string head(const SlurmConfig& config, const std::string& job_name) {
  std::string text = "#!/bin/bash\n" + option("job-name", job_name);
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
  const std::string range = "1-" + std::to_string(job.num_tasks) +
                            (slurm.max_running_tasks > 0 ? "%" + std::to_string(slurm.max_running_tasks) : "");
  const double worker_mb = slurm.memory_per_cpu_mb * kMemoryMargin;
  const bool limit = config.memory_limit_mb <= 0.0 || config.memory_limit_mb > worker_mb;
  std::string text = head(slurm, config.name);
  text += option("array", range);
  text += option("cpus-per-task", std::to_string(slurm.cpus_per_task));
  text += option("mem-per-cpu", std::to_string(static_cast<int>(std::ceil(slurm.memory_per_cpu_mb))) + "M");
  text += option("time", std::to_string(job.time_limit_min));
  text += "#SBATCH --requeue\n#SBATCH --open-mode=append\n";
  text += option("signal", "B:USR1@60");
  text += option("output", in_shell_quotes((out / "slurm" / "%A_%a.log").string()));
  text += further(slurm);
  text +=
      "\n# Every task flies its part of the batch and stores each episode as it ends. Whatever starts again, because "
      "it was\n"
      "# killed, its node died or its time ran out, flies only what is missing.\n"
      "fly() {\n  " +
      in_shell_quotes(program.string()) + " batch " + in_shell_quotes(plan.file().string()) + " --out " +
      in_shell_quotes(out.string()) + " --resume \\\n    --shard \"${SLURM_ARRAY_TASK_ID}/" +
      std::to_string(job.num_tasks) + "\" --jobs " + std::to_string(slurm.cpus_per_task);
  if (limit) text += " --memory-limit " + std::to_string(static_cast<int>(worker_mb));
  text +=
      " &\n  work=$!\n  wait \"$work\"\n}\n"
      "out_of_time() {\n"
      "  kill -TERM \"$work\"; wait \"$work\"\n"
      "  [ \"${SLURM_RESTART_COUNT:-0}\" -lt 20 ] && scontrol requeue "
      "\"${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}\"\n"
      "  exit 1\n"
      "}\n"
      "trap out_of_time USR1\n"
      "for attempt in 1 2 3; do\n"
      "  fly\n"
      "  status=$?\n"
      "  [ \"$status\" -le 128 ] && break  # above: ended by a signal\n"
      "done\n"
      "exit \"$status\"\n";
  return text;
}

std::string merge_script(const BatchPlan& plan, const fs::path& out, const fs::path& program) {
  std::string text = head(plan.config().slurm, plan.config().name + "-merge");
  text += option("time", "60") + option("mem", "4000M");
  text += option("output", in_shell_quotes((out / "slurm" / "merge_%j.log").string()));
  text += "\nset -e\n";
  const std::string swiftlet = in_shell_quotes(program.string()), directory = in_shell_quotes(out.string());
  text += swiftlet + " batch merge --out " + directory + " " + directory + "\n";
  return text + swiftlet + " report " + directory + "\n";
}

std::string sbatch(const std::string& arguments) {
  const std::string command = "sbatch --parsable " + arguments + " 2>&1";
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot start sbatch");
  std::string said;
  std::array<char, 256> buffer;
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) said += buffer.data();
  const int status = ::pclose(pipe);
  while (!said.empty() && said.back() == '\n') said.pop_back();
  if (status != 0) {
    throw std::runtime_error("sbatch ended with status " +
                             std::to_string(WIFEXITED(status) ? WEXITSTATUS(status) : -1) + ": " + said);
  }
  return said.substr(0, said.find(';'));  // "job;cluster"
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

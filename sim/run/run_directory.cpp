// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/run_directory.hpp"

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>

#include "swiftlet/sim/errors.hpp"

namespace swiftlet::sim {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPartial = ".partial-";

bool is_replaceable(const fs::path& directory) {
  if (!fs::exists(directory)) return true;
  if (!fs::is_directory(directory)) return false;
  return fs::is_empty(directory) || fs::exists(directory / "summary.json");
}

// Removes what killed runs of this name left behind; a partial directory whose process lives is left alone.
void remove_stale(const fs::path& parent, const std::string& prefix) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(parent, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(prefix, 0) != 0) continue;
    const long pid = std::strtol(name.c_str() + prefix.size(), nullptr, 10);
    const bool alive = pid > 0 && (kill(static_cast<pid_t>(pid), 0) == 0 || errno == EPERM);
    if (!alive) fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

RunDirectory::RunDirectory(fs::path destination) : destination_(fs::absolute(destination).lexically_normal()) {
  if (!destination_.has_filename()) destination_ = destination_.parent_path();  // "runs/a/" names runs/a
  if (!is_replaceable(destination_)) {
    throw InputError(
        destination_.string() +
        ": expected a new name, an empty directory or an earlier run (with a summary.json), found something "
        "else; it was left as it is");
  }
  const std::string prefix = "." + destination_.filename().string() + kPartial;
  try {
    fs::create_directories(destination_.parent_path());
    remove_stale(destination_.parent_path(), prefix);
    partial_ = destination_.parent_path() / (prefix + std::to_string(getpid()));
    fs::remove_all(partial_);
    fs::create_directory(partial_);
  } catch (const fs::filesystem_error& error) {
    throw InputError(destination_.string() +
                     ": expected a directory that can be made, found: " + error.code().message());
  }
}

RunDirectory::~RunDirectory() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(partial_, ignored);
}

void RunDirectory::commit() {
  // The earlier run is moved aside first, so that at no moment a half-replaced directory bears the name.
  const fs::path aside = partial_.string() + ".replaced";
  try {
    if (fs::exists(destination_)) fs::rename(destination_, aside);
    fs::rename(partial_, destination_);
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error(destination_.string() + ": cannot move the finished run there: " + error.code().message());
  }
  committed_ = true;
  std::error_code ignored;
  fs::remove_all(aside, ignored);
}

}  // namespace swiftlet::sim

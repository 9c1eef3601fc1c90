// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/run_directory.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "swiftlet/sim/errors.hpp"

namespace swiftlet::sim {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPartial = ".partial-";
constexpr const char* kReplaced = ".replaced";  // beside the partial directory

bool is_replaceable(const fs::path& directory) {
  if (!fs::exists(directory)) return true;
  if (!fs::is_directory(directory)) return false;
  return fs::is_empty(directory) || fs::exists(directory / "summary.json");
}

bool lies_in(const fs::path& path, const fs::path& directory) {
  const fs::path above = fs::weakly_canonical(directory);
  const fs::path below = fs::weakly_canonical(path);
  return std::mismatch(above.begin(), above.end(), below.begin(), below.end()).first == above.end();
}

void keep(std::span<const NamedFile> inputs, const fs::path& destination) {
  for (const NamedFile& input : inputs) {
    if (!lies_in(input.path, destination)) continue;
    throw InputError(input.key + ": expected a file outside of " + destination.string() +
                     ", because the run replaces what is there, found " + input.path);
  }
}

// Removes what killed runs of this name left behind; a partial directory whose process lives is left alone. An earlier
// run that was moved aside and not yet replaced comes back.
void remove_stale(const fs::path& destination, const std::string& prefix) {
  std::error_code ignored;
  std::vector<fs::path> stale;
  for (const auto& entry : fs::directory_iterator(destination.parent_path(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(prefix, 0) != 0) continue;
    const long pid = std::strtol(name.c_str() + prefix.size(), nullptr, 10);
    const bool alive = pid > 0 && (kill(static_cast<pid_t>(pid), 0) == 0 || errno == EPERM);
    if (!alive) stale.push_back(entry.path());
  }
  for (const fs::path& path : stale) {
    if (path.native().ends_with(kReplaced) && !fs::exists(destination)) {
      fs::rename(path, destination);
    } else {
      fs::remove_all(path, ignored);
    }
  }
}

void rename_at_once(const fs::path& from, const fs::path& to, unsigned flags) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags) == 0) return;
  throw fs::filesystem_error("rename", from, to, std::error_code(errno, std::generic_category()));
}

/// File systems of networks may not know how to exchange two names.
bool is_unsupported(const fs::filesystem_error& error) {
  const int code = error.code().value();
  return code == EINVAL || code == ENOSYS || code == EOPNOTSUPP;
}

}  // namespace

RunDirectory::RunDirectory(fs::path destination, std::span<const NamedFile> inputs)
    : destination_(fs::absolute(destination).lexically_normal()) {
  if (!destination_.has_filename()) destination_ = destination_.parent_path();  // "runs/a/" names runs/a
  keep(inputs, destination_);
  if (!is_replaceable(destination_)) {
    throw InputError(
        destination_.string() +
        ": expected a new name, an empty directory or an earlier run (with a summary.json), found something "
        "else; it was left as it is");
  }
  const std::string prefix = "." + destination_.filename().string() + kPartial;
  try {
    fs::create_directories(destination_.parent_path());
    remove_stale(destination_, prefix);
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
  try {
    put_in_place();
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error(destination_.string() + ": cannot move the finished run there: " + error.code().message());
  }
}

// The earlier run and the new one change places at once, and what is not ours is never removed.
void RunDirectory::put_in_place() {
  if (!is_replaceable(destination_)) {
    const fs::path other = destination_.string() + ".finished-" + std::to_string(getpid());
    rename_at_once(partial_, other, RENAME_NOREPLACE);
    committed_ = true;
    throw std::runtime_error(destination_.string() +
                             ": somebody else has put something there during the run; the finished run is " +
                             other.string());
  }
  fs::path earlier = partial_;
  try {
    rename_at_once(partial_, destination_, fs::exists(destination_) ? RENAME_EXCHANGE : RENAME_NOREPLACE);
  } catch (const fs::filesystem_error& error) {
    if (!is_unsupported(error)) throw;
    // In two steps; remove_stale() takes back the first when the second did not happen.
    earlier = partial_.string() + kReplaced;
    if (fs::exists(destination_)) fs::rename(destination_, earlier);
    fs::rename(partial_, destination_);
  }
  committed_ = true;
  std::error_code ignored;
  fs::remove_all(earlier, ignored);
}

}  // namespace swiftlet::sim

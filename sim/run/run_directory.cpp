// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/run_directory.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <random>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPartial = ".partial-";
constexpr const char* kReplaced = ".replaced";  // suffix, beside the partial directory
/// Lock file of a run in its partial directory. Directories without it do not belong to runs.
constexpr const char* kLock = ".unfinished-run";
constexpr std::size_t kSuffixDigits = 16;  // digits of hex64()

/// A dangling link is not a free name: its disk may not be mounted.
bool is_replaceable(const fs::path& directory) {
  std::error_code error;
  if (fs::symlink_status(directory, error).type() == fs::file_type::not_found) return true;
  if (!fs::is_directory(directory, error)) return false;
  return fs::is_empty(directory, error) || fs::exists(directory / "summary.json", error);
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

bool is_partial_name(const std::string& name, const std::string& prefix) {
  return name.starts_with(prefix) && name.size() == prefix.size() + kSuffixDigits &&
         name.find_first_not_of("0123456789abcdef", prefix.size()) == std::string::npos;
}

/// Opens and locks the file. Negative when there is no such file, when a run on any machine or in any container holds
/// the lock, or when the file system has no locks.
int open_locked(const fs::path& file, int flags) {
  const int lock = ::open(file.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | flags, 0666);
  if (lock < 0 || ::flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  ::close(lock);
  return -1;
}

/// Creates the lock file, which gets its name only after it is locked. Where the file system has no locks it is not
/// created, and no other run removes the directory.
int make_lock(const fs::path& partial) {
  const fs::path file = partial / kLock, unlocked = file.string() + ".new";
  const int lock = open_locked(unlocked, O_CREAT | O_EXCL);
  std::error_code ignored;
  if (lock >= 0) {
    fs::rename(unlocked, file, ignored);
  } else {
    fs::remove(unlocked, ignored);
  }
  return lock;
}

fs::path make_partial(const fs::path& destination, const std::string& prefix) {
  std::random_device random;  // names must differ between all machines and containers that share the folder
  for (;;) {
    const std::uint64_t number = std::uint64_t{random()} << 32 | random();
    fs::path partial = destination.parent_path() / (prefix + hex64(number));
    if (fs::create_directory(partial)) return partial;
  }
}

// Removes directories of killed runs of this name. An earlier run that was moved aside and not yet replaced is
// restored.
void remove_stale(const fs::path& destination, const std::string& prefix) {
  std::error_code ignored;
  std::vector<fs::path> partials;
  for (const auto& entry : fs::directory_iterator(destination.parent_path(), ignored)) {
    if (is_partial_name(entry.path().filename().string(), prefix) && !entry.is_symlink(ignored))
      partials.push_back(entry.path());
  }
  for (const fs::path& partial : partials) {
    const int lock = open_locked(partial / kLock, 0);
    if (lock < 0) continue;
    const fs::path replaced = partial.string() + kReplaced;
    if (fs::is_directory(replaced, ignored) && !fs::exists(destination, ignored))
      fs::rename(replaced, destination, ignored);
    fs::remove_all(partial, ignored);
    ::close(lock);
  }
}

std::string found_at(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error) && fs::is_symlink(path, error))
    return "a link to " + fs::read_symlink(path, error).string() + ", which is not there";
  return "something else";
}

void rename_at_once(const fs::path& from, const fs::path& to, unsigned flags) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags) == 0) return;
  throw fs::filesystem_error("rename", from, to, std::error_code(errno, std::generic_category()));
}

/// Network file systems may not support exchanging two names.
bool is_unsupported(const fs::filesystem_error& error) {
  const int code = error.code().value();
  return code == EINVAL || code == ENOSYS || code == EOPNOTSUPP;
}

}  // namespace

RunDirectory::RunDirectory(fs::path destination, std::span<const NamedFile> inputs)
    : destination_(fs::absolute(destination).lexically_normal()) {
  if (!destination_.has_filename()) destination_ = destination_.parent_path();  // "runs/a/" means runs/a
  if (!is_replaceable(destination_)) {
    throw InputError(destination_.string() +
                     ": expected a new name, an empty directory or an earlier run (with a summary.json), found " +
                     found_at(destination_) + "; it was left as it is");
  }
  keep(inputs, destination_);
  const std::string prefix = "." + destination_.filename().string() + kPartial;
  try {
    fs::create_directories(destination_.parent_path());
    remove_stale(destination_, prefix);
    partial_ = make_partial(destination_, prefix);
    lock_ = make_lock(partial_);
  } catch (const fs::filesystem_error& error) {
    throw InputError(destination_.string() +
                     ": expected a directory that can be made, found: " + error.code().message());
  }
}

RunDirectory::~RunDirectory() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(partial_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

void RunDirectory::commit() {
  try {
    put_in_place();
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error(destination_.string() + ": cannot move the finished run there: " + error.code().message());
  }
}

// Exchanges the earlier run and the new one atomically; directories of other origin are never removed.
void RunDirectory::put_in_place() {
  if (!is_replaceable(destination_)) {
    const std::string suffix = partial_.string().substr(partial_.string().size() - kSuffixDigits);
    const fs::path other = destination_.string() + ".finished-" + suffix;
    rename_at_once(partial_, other, RENAME_NOREPLACE);
    committed_ = true;
    std::error_code ignored;
    fs::remove(other / kLock, ignored);
    throw std::runtime_error(destination_.string() + ": expected no new files after the run, found " +
                             found_at(destination_) + "; the finished run is " + other.string());
  }
  fs::path earlier = partial_;
  try {
    rename_at_once(partial_, destination_, fs::exists(destination_) ? RENAME_EXCHANGE : RENAME_NOREPLACE);
  } catch (const fs::filesystem_error& error) {
    if (!is_unsupported(error)) throw;
    // Two steps; remove_stale() reverts the first if the second did not happen.
    earlier = partial_.string() + kReplaced;
    if (fs::exists(destination_)) fs::rename(destination_, earlier);
    fs::rename(partial_, destination_);
  }
  committed_ = true;
  std::error_code ignored;
  fs::remove(destination_ / kLock, ignored);
  fs::remove_all(earlier, ignored);
}

}  // namespace swiftlet::sim

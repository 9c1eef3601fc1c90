// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/result_store.hpp"

#include <sqlite3.h>
#include <sys/vfs.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "embedded/sim_batch.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/shallow_json.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Version of the tables; databases of other versions are refused.
constexpr int kFormat = 1;
// [-] Steps of SQLite between checks of the limit. Larger values overrun the limit by more.
constexpr int kStepsAtOnce = 10'000;

/// Upper bound of the steps of SQLite's virtual machine for any statement on a database of this size. A damaged tree
/// may refer to one page many times on each level, and reading it would not end.
std::uint64_t most_steps(const fs::path& database) {
  std::uint64_t bytes = 0;
  for (const char* journal : {"", "-wal"}) {
    std::error_code absent;
    const std::uintmax_t size = fs::file_size(database.string() + journal, absent);
    if (!absent) bytes += size;
  }
  return 1'000'000 + 100 * bytes;
}

/// Throws the exception that corresponds to an SQLite error for this file.
[[noreturn]] void fail_on(const fs::path& file, int error) {
  const std::string place = file.string() + ": ", expected = place + "expected results of a batch, found ";
  switch (error & 0xFF) {
    case SQLITE_CORRUPT:
    case SQLITE_INTERRUPT:
      throw InputError(expected + "a damaged file");
    case SQLITE_NOTADB:
      throw InputError(expected + "something else, which is no database of SQLite");
    case SQLITE_ERROR:  // a statement that does not match the tables
    case SQLITE_AUTH:
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH:
      throw InputError(expected + "something else, a database with other tables");
    case SQLITE_CANTOPEN:
      throw std::runtime_error(place + "cannot be opened; does it exist, and may it be read?");
    case SQLITE_READONLY:
    case SQLITE_PERM:
      throw std::runtime_error(place + "cannot be written: it is read-only");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw std::runtime_error(place + "is in use by another process; try again when that has ended");
    case SQLITE_FULL:
      throw std::runtime_error(place + "cannot be written: the disk is full");
    case SQLITE_NOMEM:
      throw std::bad_alloc();
    default:
      throw std::runtime_error(place + "cannot be read or written");
  }
}

class Statement {
 public:
  Statement(sqlite3* database, const char* sql)
      : database_(database), steps_left_(most_steps(sqlite3_db_filename(database, "main"))) {
    if (limited([&] { return sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr); }) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(const std::string& text) {
    sqlite3_bind_text(statement_, ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
    return *this;
  }
  Statement& bind(std::uint64_t value) {
    sqlite3_bind_int64(statement_, ++bound_, static_cast<sqlite3_int64>(value));
    return *this;
  }
  Statement& bind(double value) {  // NaN becomes NULL
    std::isfinite(value) ? sqlite3_bind_double(statement_, ++bound_, value) : sqlite3_bind_null(statement_, ++bound_);
    return *this;
  }

  /// Advances to the next row; false at the end.
  bool step() {
    const int result = limited([&] { return sqlite3_step(statement_); });
    if (result == SQLITE_ROW) return true;
    if (result != SQLITE_DONE) fail();
    return false;
  }
  void run() {
    while (step()) {
    }
    sqlite3_reset(statement_);
    bound_ = 0;
  }

  std::string text(int column) const {
    const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return data == nullptr ? "" : std::string(data, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
  }
  std::uint64_t whole(int column) const { return static_cast<std::uint64_t>(sqlite3_column_int64(statement_, column)); }
  double number(int column) const {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL ? std::numeric_limits<double>::quiet_NaN()
                                                                  : sqlite3_column_double(statement_, column);
  }

 private:
  /// Result of SQLite; SQLITE_INTERRUPT when this statement exceeds its steps.
  template <class Action>
  int limited(const Action& action) {
    const auto spend = [](void* self) {
      std::uint64_t& left = static_cast<Statement*>(self)->steps_left_;
      left -= std::min<std::uint64_t>(left, kStepsAtOnce);
      return left == 0 ? 1 : 0;
    };
    sqlite3_progress_handler(database_, kStepsAtOnce, spend, this);
    const int result = action();
    sqlite3_progress_handler(database_, 0, nullptr, nullptr);
    return result;
  }

  [[noreturn]] void fail() const { fail_on(sqlite3_db_filename(database_, "main"), sqlite3_errcode(database_)); }

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
  std::uint64_t steps_left_;
};

/// Network file systems, where the shared memory of write-ahead logging does not work (SQLite's manual, "WAL").
bool is_network_file_system(const fs::path& directory) {
  struct statfs info {};
  if (statfs(directory.c_str(), &info) != 0) return false;
  constexpr long kNetwork[] = {
      0x6969 /* NFS */,       0x0BD00BD0 /* Lustre */, 0x47504653 /* GPFS */, 0xFF534D42L /* CIFS */,
      0xFE534D42L /* SMB2 */, 0x19830326 /* BeeGFS */, 0x00C36400 /* Ceph */, 0x517B /* SMB */};
  for (const long type : kNetwork) {
    if ((static_cast<unsigned long>(info.f_type) & 0xFFFFFFFFUL) == static_cast<unsigned long>(type)) return true;
  }
  return false;
}

std::string joined(const std::vector<std::string>& words) { return Json(words).dump(); }

bool same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool same_row(const MetricRow& a, const MetricRow& b) {
  return a.name == b.name && a.vehicle == b.vehicle && a.unit == b.unit && a.text == b.text &&
         same_number(a.value, b.value);
}

}  // namespace

bool EpisodeRow::agrees_with(const EpisodeRow& other) const {
  return id == other.id && variant == other.variant && point == other.point && seed == other.seed &&
         parameters == other.parameters && status == other.status && outcome == other.outcome &&
         state_hash == other.state_hash && same_number(simulated_s, other.simulated_s) &&
         std::equal(metrics.begin(), metrics.end(), other.metrics.begin(), other.metrics.end(), same_row);
}

struct ResultStore::Impl {
  fs::path file;
  sqlite3* database = nullptr;

  ~Impl() { sqlite3_close_v2(database); }

  void run(const char* sql) const {
    if (const int error = sqlite3_exec(database, sql, nullptr, nullptr, nullptr); error != SQLITE_OK)
      fail_on(file, error);
  }

  template <class Action>
  void transaction(const Action& action) {
    run("BEGIN IMMEDIATE");
    try {
      action();
      run("COMMIT");
    } catch (...) {
      sqlite3_exec(database, "ROLLBACK", nullptr, nullptr, nullptr);
      throw;
    }
  }

  void check_format() const {
    const std::string format = value("format");
    if (format != std::to_string(kFormat)) {
      throw InputError(file.string() + ": expected results in format " + std::to_string(kFormat) + ", found \"" +
                       format + "\"");
    }
  }

  void make_schema() {
    transaction([&] {
      run(embedded::result_store_sql.data());
      run(("INSERT INTO batch VALUES('format', '" + std::to_string(kFormat) + "')").c_str());
    });
  }

  bool is_empty() const { return !Statement(database, "SELECT 1 FROM sqlite_schema LIMIT 1").step(); }

  std::string value(const char* key) const {
    Statement query(database, "SELECT value FROM batch WHERE key = ?");
    query.bind(std::string(key));
    return query.step() ? query.text(0) : "";
  }

  std::vector<std::string> words(const char* key) const {
    const std::string text = value(key);
    if (text.empty()) return {};
    const Json list = parse_shallow<Json>(text);
    if (!list.is_array() || !std::all_of(list.begin(), list.end(), [](const Json& word) { return word.is_string(); })) {
      throw InputError(file.string() + ": batch." + key + ": expected a list of words, found \"" + text + "\"");
    }
    return list.get<std::vector<std::string>>();
  }

  void add_metrics(EpisodeRow& row) const {
    Statement query(database,
                    "SELECT name, vehicle, value, unit, text FROM metrics WHERE episode = ? ORDER BY position");
    query.bind(row.id);
    while (query.step()) {
      row.metrics.push_back({query.text(0), query.text(1), query.number(2), query.text(3), query.text(4)});
    }
  }

  std::vector<EpisodeRow> rows(const char* where, std::optional<std::uint64_t> id, bool with_metrics) const {
    const auto names = words("parameters");
    Statement query(database,
                    (std::string("SELECT e.episode, variant, point, seed, status, outcome, state_hash, simulated_s, "
                                 "message, command, host, setup_wall_s, flight_wall_s, wall_s, built_world FROM "
                                 "episodes e LEFT JOIN timing t ON t.episode = e.episode ") +
                     where + " ORDER BY e.episode")
                        .c_str());
    if (id) query.bind(*id);
    std::vector<EpisodeRow> found;
    while (query.step()) {
      EpisodeRow row;
      row.id = query.whole(0);
      row.variant = query.text(1);
      row.point = query.whole(2);
      row.seed = query.whole(3);
      row.status = query.text(4);
      row.outcome = query.text(5);
      row.state_hash = query.text(6);
      row.simulated_s = query.number(7);
      row.message = query.text(8);
      row.command = query.text(9);
      row.host = query.text(10);
      row.setup_wall_s = query.number(11);
      row.flight_wall_s = query.number(12);
      row.wall_s = query.number(13);
      row.built_world = query.whole(14) != 0;
      row.parameters = parameters_of(row.id, names);
      if (with_metrics) add_metrics(row);
      found.push_back(std::move(row));
    }
    return found;
  }

  std::vector<std::string> parameters_of(std::uint64_t id, const std::vector<std::string>& names) const {
    std::map<std::string, std::string> values;
    Statement query(database, "SELECT name, value FROM parameters WHERE episode = ?");
    query.bind(id);
    while (query.step()) values[query.text(0)] = query.text(1);
    std::vector<std::string> ordered;
    for (const std::string& name : names) ordered.push_back(values[name]);
    return ordered;
  }
};

ResultStore::ResultStore(fs::path file, Mode mode) : impl_(std::make_unique<Impl>()) {
  impl_->file = std::move(file);
  std::error_code absent;
  if (mode != Mode::kRead && fs::is_symlink(impl_->file, absent))
    throw InputError(impl_->file.string() +
                     ": expected a database or nothing, found a link; output does not follow links");
  const int flags = mode == Mode::kRead ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  // Opens for writing even to read: only then can the journal of a killed batch be read.
  int result = sqlite3_open_v2(impl_->file.c_str(), &impl_->database, flags, nullptr);
  if (result != SQLITE_OK && mode == Mode::kRead) {
    sqlite3_close_v2(impl_->database);
    result = sqlite3_open_v2(impl_->file.c_str(), &impl_->database, SQLITE_OPEN_READONLY, nullptr);
  }
  if (result != SQLITE_OK) fail_on(impl_->file, result);
  sqlite3_busy_timeout(impl_->database, 10'000);
  // An untrusted database must not execute code (SQLite's page "Defense Against The Dark Arts").
  for (const int power : {SQLITE_DBCONFIG_ENABLE_VIEW, SQLITE_DBCONFIG_ENABLE_TRIGGER, SQLITE_DBCONFIG_TRUSTED_SCHEMA})
    sqlite3_db_config(impl_->database, power, 0, nullptr);
  if (mode == Mode::kRead) {
    impl_->check_format();
    return;
  }

  const bool fresh = impl_->is_empty();
  if (!fresh && mode == Mode::kCreate)
    throw InputError(impl_->file.string() + ": expected no results there yet, found some");
  const bool network =
      is_network_file_system(impl_->file.parent_path().empty() ? fs::path(".") : impl_->file.parent_path());
  impl_->run(network ? "PRAGMA journal_mode = TRUNCATE" : "PRAGMA journal_mode = WAL");
  impl_->run("PRAGMA synchronous = NORMAL");
  fresh ? impl_->make_schema() : impl_->check_format();
}

ResultStore::~ResultStore() = default;
ResultStore::ResultStore(ResultStore&&) noexcept = default;

const fs::path& ResultStore::file() const { return impl_->file; }

std::optional<BatchInfo> ResultStore::info() const {
  BatchInfo info;
  info.fingerprint = impl_->value("fingerprint");
  if (info.fingerprint.empty()) return std::nullopt;
  info.name = impl_->value("name");
  info.description = impl_->value("description");
  info.file = impl_->value("file");
  info.text = impl_->value("text");
  info.version = impl_->value("version");
  info.git_revision = impl_->value("git_revision");
  const std::string episodes = impl_->value("num_episodes");
  const auto num_episodes = number_in<std::uint64_t>(episodes);
  if (!num_episodes)
    throw InputError(impl_->file.string() + ": batch.num_episodes: expected a whole number, found \"" + episodes +
                     "\"");
  info.num_episodes = *num_episodes;
  info.variants = impl_->words("variants");
  info.parameters = impl_->words("parameters");
  return info;
}

void ResultStore::set_info(const BatchInfo& info) {
  impl_->transaction([&] {
    Statement insert(impl_->database, "INSERT OR REPLACE INTO batch VALUES(?, ?)");
    const auto set = [&](const char* key, const std::string& value) {
      insert.bind(std::string(key)).bind(value).run();
    };
    set("name", info.name);
    set("description", info.description);
    set("file", info.file);
    set("text", info.text);
    set("fingerprint", info.fingerprint);
    set("version", info.version);
    set("git_revision", info.git_revision);
    set("num_episodes", std::to_string(info.num_episodes));
    set("variants", joined(info.variants));
    set("parameters", joined(info.parameters));
  });
}

std::set<std::uint64_t> ResultStore::episode_ids() const {
  std::set<std::uint64_t> ids;
  Statement query(impl_->database, "SELECT episode FROM episodes ORDER BY episode");
  while (query.step()) ids.insert(ids.end(), query.whole(0));
  return ids;
}

std::map<std::string, std::uint64_t> ResultStore::count_by_status() const {
  std::map<std::string, std::uint64_t> counts;
  Statement query(impl_->database, "SELECT status, count(*) FROM episodes GROUP BY status");
  while (query.step()) counts[query.text(0)] = query.whole(1);
  return counts;
}

void ResultStore::add(const EpisodeRow& row) {
  const auto names = impl_->words("parameters");
  impl_->transaction([&] {
    for (const char* table : {"episodes", "parameters", "metrics", "timing"}) {
      Statement(impl_->database, (std::string("DELETE FROM ") + table + " WHERE episode = ?").c_str())
          .bind(row.id)
          .run();
    }
    Statement(impl_->database, "INSERT INTO episodes VALUES(?,?,?,?,?,?,?,?,?,?)")
        .bind(row.id)
        .bind(row.variant)
        .bind(static_cast<std::uint64_t>(row.point))
        .bind(row.seed)
        .bind(row.status)
        .bind(row.outcome)
        .bind(row.state_hash)
        .bind(row.simulated_s)
        .bind(row.message)
        .bind(row.command)
        .run();
    Statement parameter(impl_->database, "INSERT INTO parameters VALUES(?,?,?)");
    for (std::size_t i = 0; i < row.parameters.size(); ++i) {
      parameter.bind(row.id).bind(names.at(i)).bind(row.parameters[i]).run();
    }
    Statement metric(impl_->database, "INSERT INTO metrics VALUES(?,?,?,?,?,?,?)");
    for (std::size_t i = 0; i < row.metrics.size(); ++i) {
      const MetricRow& m = row.metrics[i];
      metric.bind(row.id)
          .bind(static_cast<std::uint64_t>(i))
          .bind(m.name)
          .bind(m.vehicle)
          .bind(m.text.empty() ? m.value : std::nan(""))
          .bind(m.unit)
          .bind(m.text)
          .run();
    }
    Statement(impl_->database, "INSERT INTO timing VALUES(?,?,?,?,?,?)")
        .bind(row.id)
        .bind(row.host)
        .bind(row.setup_wall_s)
        .bind(row.flight_wall_s)
        .bind(row.wall_s)
        .bind(static_cast<std::uint64_t>(row.built_world ? 1 : 0))
        .run();
  });
}

std::uint64_t ResultStore::remove_unfinished() {
  std::uint64_t count = 0;
  impl_->transaction([&] {
    for (const char* table : {"parameters", "metrics", "timing"}) {
      impl_->run((std::string("DELETE FROM ") + table +
                  " WHERE episode IN (SELECT episode FROM episodes WHERE status <> 'done')")
                     .c_str());
    }
    impl_->run("DELETE FROM episodes WHERE status <> 'done'");
    count = static_cast<std::uint64_t>(sqlite3_changes(impl_->database));
  });
  return count;
}

std::vector<EpisodeRow> ResultStore::episodes(bool with_metrics) const {
  return impl_->rows("", std::nullopt, with_metrics);
}

std::optional<EpisodeRow> ResultStore::episode(std::uint64_t id) const {
  auto rows = impl_->rows("WHERE e.episode = ?", id, true);
  return rows.empty() ? std::nullopt : std::optional<EpisodeRow>(std::move(rows.front()));
}

std::string ResultStore::dump() const {
  std::string text;
  const auto add = [&](const char* sql, int columns) {
    Statement query(impl_->database, sql);
    while (query.step()) {
      for (int i = 0; i < columns; ++i) text += query.text(i) + "|";
      text += "\n";
    }
  };
  add("SELECT key, value FROM batch ORDER BY key", 2);
  add("SELECT episode, variant, point, seed, status, outcome, state_hash, simulated_s, message, command FROM episodes "
      "ORDER BY episode",
      10);
  add("SELECT episode, name, value FROM parameters ORDER BY episode, name", 3);
  add("SELECT episode, position, name, vehicle, CASE WHEN value IS NULL THEN '' ELSE printf('%!.17g', value) END, "
      "unit, text FROM metrics ORDER BY episode, position",
      7);
  return text;
}

void ResultStore::close() {
  // A closed database is one file that can also be read from read-only media.
  sqlite3_exec(impl_->database, "PRAGMA wal_checkpoint(TRUNCATE)", nullptr, nullptr, nullptr);
  sqlite3_exec(impl_->database, "PRAGMA journal_mode = DELETE", nullptr, nullptr, nullptr);
  if (sqlite3_close(impl_->database) != SQLITE_OK)
    throw std::runtime_error(impl_->file.string() + ": cannot be closed");
  impl_->database = nullptr;
}

}  // namespace swiftlet::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/result_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <array>
#include <fstream>
#include <functional>

#include "swiftlet/sim/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;

/// A database of one episode, as a stranger may change it.
class Stranger : public ::testing::Test {
 protected:
  static constexpr int kPageBytes = 512;
  using Page = std::array<unsigned char, kPageBytes>;

  Stranger() {
    ResultStore store(file_, ResultStore::Mode::kCreate);
    BatchInfo info;
    info.fingerprint = "1234";
    info.num_episodes = 1;
    info.variants = {"fast", "slow"};
    store.set_info(info);
    EpisodeRow row;
    row.variant = "fast";
    row.status = "done";
    store.add(row);
    store.close();
  }

  /// The first column of the last row.
  int run(const std::string& sql) const {
    sqlite3* database = nullptr;
    sqlite3_open(file_.c_str(), &database);
    int number = 0;
    const auto keep = [](void* to, int, char** values, char**) {
      *static_cast<int*>(to) = values[0] == nullptr ? 0 : std::atoi(values[0]);
      return 0;
    };
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), keep, &number, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
    return number;
  }

  Page page(int number) const {
    Page bytes;
    std::ifstream in(file_, std::ios::binary);
    in.seekg(std::streamoff{kPageBytes} * (number - 1)).read(reinterpret_cast<char*>(bytes.data()), kPageBytes);
    return bytes;
  }
  void set_page(int number, const Page& bytes) const {
    std::fstream out(file_, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp(std::streamoff{kPageBytes} * (number - 1)).write(reinterpret_cast<const char*>(bytes.data()), kPageBytes);
  }

  std::string refusal(const std::function<void(const ResultStore&)>& read) const {
    try {
      read(ResultStore(file_, ResultStore::Mode::kRead));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryDirectory folder_;
  std::filesystem::path file_ = folder_.path() / "results.sqlite";
};

/// An inner page of a table all of whose children are one and the same page (SQLite's "Database File Format", 1.6).
std::array<unsigned char, 512> page_of_one_child(int child) {
  constexpr int kCells = 50, kCellBytes = 5, kHeadBytes = 12, kPageBytes = 512;
  std::array<unsigned char, kPageBytes> page{};
  const auto put = [&page](int at, int bytes, int value) {
    for (int i = 0; i < bytes; ++i)
      page[static_cast<std::size_t>(at + i)] = static_cast<unsigned char>(value >> 8 * (bytes - 1 - i));
  };
  put(0, 1, 5);  // inner page of a table
  put(3, 2, kCells);
  put(5, 2, kPageBytes - kCells * kCellBytes);
  put(8, 4, child);
  for (int i = 0; i < kCells; ++i) {
    const int cell = kPageBytes - (i + 1) * kCellBytes;
    put(kHeadBytes + 2 * i, 2, cell);
    put(cell, 4, child);
    put(cell + 4, 1, i);  // its greatest row
  }
  return page;
}

TEST_F(Stranger, AListThatIsNoneIsToldWithItsPlace) {
  for (const char* list : {"{\"a\": 1}", "[1, 2]", "[\"fast\"", "no list"}) {
    run(std::string("UPDATE batch SET value = '") + list + "' WHERE key = 'variants'");
    EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.info(); }),
                HasSubstr("results.sqlite: batch.variants: expected a list of words, found \"" + std::string(list)));
  }
}

TEST_F(Stranger, NoQueryOfTheirsIsRun) {
  run("ALTER TABLE batch RENAME TO told; CREATE VIEW batch AS SELECT * FROM told");
  EXPECT_THAT(refusal([](const ResultStore&) {}), HasSubstr("expected results of a batch, found something else"));
}

TEST_F(Stranger, ATreeThatNamesItsPagesManyTimesIsNotReadForEver) {
  run("PRAGMA page_size = 512; VACUUM; CREATE TABLE room(x)");
  run("INSERT INTO room VALUES(zeroblob(5000))");
  const int root = run("SELECT rootpage FROM sqlite_schema WHERE name = 'episodes'");
  const int last = run("PRAGMA page_count");
  set_page(last, page(root));  // the leaf with the only episode
  for (int number = last - 1; number > last - 6; --number) set_page(number, page_of_one_child(number + 1));
  set_page(root, page_of_one_child(last - 5));
  // It stands there fifty to the sixth times.
  const auto damaged = HasSubstr("expected results of a batch, found a damaged file");
  EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.count_by_status(); }), damaged);
  EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.dump(); }), damaged);
  EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.episodes(); }), damaged);
}

}  // namespace
}  // namespace swiftlet::sim

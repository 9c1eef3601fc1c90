// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/result_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;

/// A database of one episode, as a stranger may change it.
class ForeignDatabase : public ::testing::Test {
 protected:
  static constexpr int kPageBytes = 512;
  using Page = std::array<unsigned char, kPageBytes>;

  ForeignDatabase() {
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

/// An inner page of a table whose children are all the same page (SQLite's "Database File Format", 1.6).
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

TEST_F(ForeignDatabase, RefusesMalformedListsWithTheirPlace) {
  for (const char* list : {"{\"a\": 1}", "[1, 2]", "[\"fast\"", "no list"}) {
    run(std::string("UPDATE batch SET value = '") + list + "' WHERE key = 'variants'");
    EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.info(); }),
                HasSubstr("results.sqlite: batch.variants: expected a list of words, found \"" + std::string(list)));
  }
}

TEST_F(ForeignDatabase, RefusesViewsInPlaceOfTables) {
  run("ALTER TABLE batch RENAME TO hidden; CREATE VIEW batch AS SELECT * FROM hidden");
  EXPECT_THAT(refusal([](const ResultStore&) {}), HasSubstr("expected results of a batch, found something else"));
}

TEST_F(ForeignDatabase, RefusesForeignDatabasesInOwnWords) {
  const auto other = HasSubstr("results.sqlite: expected results of a batch, found something else");
  const auto read_all = [](const ResultStore& store) {
    (void)store.info();
    (void)store.count_by_status();
    (void)store.episodes();
  };
  for (const char* table : {"timing", "metrics", "parameters", "episodes", "batch"}) {
    run(std::string("DROP TABLE ") + table);
    EXPECT_THAT(refusal(read_all), AllOf(other, ::testing::Not(HasSubstr("no such table")))) << table;
  }
  run("CREATE TABLE batch(name TEXT)");
  EXPECT_THAT(refusal(read_all), AllOf(other, ::testing::Not(HasSubstr("no such column"))));
  std::ofstream(file_) << "a text that is long enough to be taken for the first page of something";
  EXPECT_THAT(refusal(read_all), HasSubstr("found something else, which is no database of SQLite"));
}

TEST_F(ForeignDatabase, LimitsReadsOfRepeatedPages) {
  run("PRAGMA page_size = 512; VACUUM; CREATE TABLE room(x)");
  run("INSERT INTO room VALUES(zeroblob(5000))");
  const int root = run("SELECT rootpage FROM sqlite_schema WHERE name = 'episodes'");
  const int last = run("PRAGMA page_count");
  set_page(last, page(root));  // the leaf with the only episode
  for (int number = last - 1; number > last - 6; --number) set_page(number, page_of_one_child(number + 1));
  set_page(root, page_of_one_child(last - 5));
  // The last page is referenced fifty to the sixth times.
  const auto damaged = HasSubstr("expected results of a batch, found a damaged file");
  EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.count_by_status(); }), damaged);
  EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.dump(); }), damaged);
  EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.episodes(); }), damaged);
}

EpisodeRow row_of(std::uint64_t id, const std::string& status = "done") {
  EpisodeRow row;
  row.id = id;
  row.variant = id % 2 == 0 ? "even" : "odd, quoted";
  row.point = 3 + id;
  row.seed = (std::uint64_t{1} << 62) + id;
  row.parameters = {"1.5", "a \"b\""};
  row.status = status;
  row.outcome = "done";
  row.state_hash = "00ff";
  row.simulated_s = 0.1 + static_cast<double>(id);
  row.message = status == "done" ? "" : "it, failed";
  row.command = "swiftlet run x";
  row.metrics = {{"path_m", "a", 1.0 / 3.0, "m", ""},
                 {"path_m", "b", std::numeric_limits<double>::quiet_NaN(), "m", ""},
                 {"outcome", "", std::numeric_limits<double>::quiet_NaN(), "", "crashed, badly"},
                 {"count", "", 7.0, "", ""}};
  row.host = "here";
  row.setup_wall_s = 0.25;
  row.flight_wall_s = std::numeric_limits<double>::quiet_NaN();
  row.wall_s = 2.5;
  row.built_world = id == 1;
  return row;
}

BatchInfo info_with_two_parameters() {
  BatchInfo info;
  info.name = "batch";
  info.description = "about";
  info.file = "/b.yaml";
  info.text = "name: batch";
  info.fingerprint = "ff";
  info.version = "1";
  info.git_revision = "r";
  info.num_episodes = 3;
  info.variants = {"even", "odd, quoted"};
  info.parameters = {"x", "name"};
  return info;
}

class Stored : public ::testing::Test {
 protected:
  TemporaryDirectory folder_;
  std::filesystem::path file_ = folder_.path() / "results.sqlite";
  ResultStore store_{file_, ResultStore::Mode::kCreate};
};

TEST_F(Stored, RoundTripsEverything) {
  EXPECT_FALSE(store_.info().has_value());
  store_.set_info(info_with_two_parameters());
  const auto info = store_.info();
  ASSERT_TRUE(info.has_value());
  EXPECT_EQ(info->description, "about");
  EXPECT_EQ(info->num_episodes, 3U);
  EXPECT_EQ(info->variants, info_with_two_parameters().variants);
  EXPECT_EQ(info->parameters, info_with_two_parameters().parameters);
  EXPECT_EQ(info->git_revision, "r");
  for (const std::uint64_t id : {2U, 0U, 1U}) store_.add(row_of(id));
  EXPECT_EQ(store_.episode_ids(), (std::set<std::uint64_t>{0, 1, 2}));
  const auto rows = store_.episodes();
  ASSERT_EQ(rows.size(), 3U);
  for (std::uint64_t id = 0; id < 3; ++id) {
    const EpisodeRow expected = row_of(id), &found = rows[id];
    EXPECT_TRUE(found.agrees_with(expected));
    EXPECT_EQ(found.message, expected.message);
    EXPECT_EQ(found.command, expected.command);
    EXPECT_EQ(found.host, "here");
    EXPECT_EQ(found.setup_wall_s, 0.25);
    EXPECT_TRUE(std::isnan(found.flight_wall_s));
    EXPECT_EQ(found.wall_s, 2.5);
    EXPECT_EQ(found.built_world, id == 1);
    ASSERT_EQ(found.metrics.size(), 4U);
    EXPECT_EQ(found.metrics[0].value, 1.0 / 3.0);
    EXPECT_EQ(found.metrics[0].unit, "m");
    EXPECT_TRUE(std::isnan(found.metrics[1].value));
    EXPECT_EQ(found.metrics[2].text, "crashed, badly");
    EXPECT_TRUE(std::isnan(found.metrics[2].value)) << "a word is no number";
    EXPECT_EQ(found.metrics[3].value, 7.0);
  }
  EXPECT_TRUE(store_.episodes(false)[0].metrics.empty());
  EXPECT_EQ(store_.episode(1)->seed, (std::uint64_t{1} << 62) + 1);
  EXPECT_EQ(store_.episode(1)->metrics.size(), 4U);
  EXPECT_FALSE(store_.episode(3).has_value());
}

TEST_F(Stored, ReplacesAnEpisodeAddedAgain) {
  store_.set_info(info_with_two_parameters());
  store_.add(row_of(1, "failed"));
  EpisodeRow again = row_of(1);
  again.metrics.pop_back();
  again.parameters = {"2", "c"};
  store_.add(again);
  ASSERT_EQ(store_.episodes().size(), 1U);
  EXPECT_EQ(store_.episode(1)->metrics.size(), 3U);
  EXPECT_EQ(store_.episode(1)->parameters, again.parameters);
  EXPECT_EQ(store_.count_by_status(), (std::map<std::string, std::uint64_t>{{"done", 1}}));
}

TEST_F(Stored, RemovesUnfinishedEpisodes) {
  store_.set_info(info_with_two_parameters());
  store_.add(row_of(0));
  store_.add(row_of(1, "failed"));
  store_.add(row_of(2, "timed_out"));
  EXPECT_EQ(store_.count_by_status(),
            (std::map<std::string, std::uint64_t>{{"done", 1}, {"failed", 1}, {"timed_out", 1}}));
  EXPECT_EQ(store_.remove_unfinished(), 2U);
  EXPECT_EQ(store_.episode_ids(), std::set<std::uint64_t>{0});
  EXPECT_EQ(store_.remove_unfinished(), 0U);
  store_.add(row_of(1));
  EXPECT_EQ(store_.episode(1)->metrics.size(), 4U) << "nothing of the earlier one is left";
}

TEST_F(Stored, DumpExcludesMachineSpecificData) {
  store_.set_info(info_with_two_parameters());
  store_.add(row_of(1));
  const std::string before = store_.dump();
  EpisodeRow same = row_of(1);
  same.host = "there";
  same.wall_s = same.setup_wall_s = 99.0;
  same.built_world = false;
  store_.add(same);
  EXPECT_EQ(store_.dump(), before);
  for (const char* line :
       {"fingerprint|ff|\n", "1|odd, quoted|4|4611686018427387905|done|done|00ff|1.1||swiftlet run x|\n",
        "1|name|a \"b\"|\n", "1|x|1.5|\n", "1|0|path_m|a|0.33333333333333331|m||\n", "1|1|path_m|b||m||\n",
        "1|2|outcome||||crashed, badly|\n", "1|3|count||7.0|||\n"}) {
    EXPECT_THAT(before, HasSubstr(line));
  }
  same.metrics[0].value += 1e-16;
  store_.add(same);
  EXPECT_NE(store_.dump(), before);
}

TEST_F(Stored, IsOneFileCreatedOnlyOnce) {
  store_.set_info(info_with_two_parameters());
  store_.close();
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
  EXPECT_THROW(ResultStore(file_, ResultStore::Mode::kCreate), InputError);
  EXPECT_NO_THROW(ResultStore(file_, ResultStore::Mode::kAppend));
  EXPECT_NO_THROW(ResultStore(file_, ResultStore::Mode::kRead));
  EXPECT_THROW(ResultStore(folder_.path() / "none.sqlite", ResultStore::Mode::kRead), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "none.sqlite"));
  EXPECT_NO_THROW(ResultStore(folder_.path() / "new.sqlite", ResultStore::Mode::kAppend));
}

TEST_F(Stored, WritesMetricsAsColumnsAndRows) {
  store_.set_info(info_with_two_parameters());
  EpisodeRow first = row_of(0);
  first.metrics.erase(first.metrics.begin() + 1);
  store_.add(first);
  store_.add(row_of(1, "failed"));
  export_csv(store_, folder_.path());
  const auto text_of = [&](const char* name) { return read_whole_file(folder_.path() / name); };
  EXPECT_EQ(text_of("episodes.csv"),
            "episode,variant,point,seed,x,name,status,state_hash,simulated_s,wall_s,a.path_m,outcome,count,b.path_m,"
            "message,command\n"
            "0,even,3,4611686018427387904,1.5,\"a \"\"b\"\"\",done,00ff,0.1,2.5,0.3333333333333333,\"crashed, "
            "badly\",7,,,swiftlet run x\n"
            "1,\"odd, quoted\",4,4611686018427387905,1.5,\"a \"\"b\"\"\",failed,00ff,1.1,2.5,0.3333333333333333,"
            "\"crashed, badly\",7,,\"it, failed\",swiftlet run x\n");
  EXPECT_EQ(text_of("metrics.csv"),
            "episode,variant,point,seed,vehicle,metric,value,unit\n"
            "0,even,3,4611686018427387904,a,path_m,0.3333333333333333,m\n"
            "0,even,3,4611686018427387904,,outcome,\"crashed, badly\",\n"
            "0,even,3,4611686018427387904,,count,7,\n"
            "1,\"odd, quoted\",4,4611686018427387905,a,path_m,0.3333333333333333,m\n"
            "1,\"odd, quoted\",4,4611686018427387905,b,path_m,,m\n"
            "1,\"odd, quoted\",4,4611686018427387905,,outcome,\"crashed, badly\",\n"
            "1,\"odd, quoted\",4,4611686018427387905,,count,7,\n");
}

TEST(EpisodeRow, AgreesOnlyWithEqualRows) {
  const EpisodeRow row = row_of(1);
  EXPECT_TRUE(row.agrees_with(row));
  const std::function<void(EpisodeRow&)> changes[] = {
      [](EpisodeRow& r) { r.id = 2; },
      [](EpisodeRow& r) { r.variant = "x"; },
      [](EpisodeRow& r) { r.point = 9; },
      [](EpisodeRow& r) { r.seed = 9; },
      [](EpisodeRow& r) { r.parameters[1] = "c"; },
      [](EpisodeRow& r) { r.status = "failed"; },
      [](EpisodeRow& r) { r.outcome = "x"; },
      [](EpisodeRow& r) { r.state_hash = "x"; },
      [](EpisodeRow& r) { r.metrics[0].name = "x"; },
      [](EpisodeRow& r) { r.metrics[0].vehicle = "x"; },
      [](EpisodeRow& r) { r.metrics[0].value = 0.3; },
      [](EpisodeRow& r) { r.metrics[1].value = 0.3; },
      [](EpisodeRow& r) { r.metrics[2].text = "x"; },
      [](EpisodeRow& r) { r.metrics.pop_back(); },
  };
  for (const auto& change : changes) {
    EpisodeRow other = row_of(1);
    change(other);
    EXPECT_FALSE(row.agrees_with(other) || other.agrees_with(row)) << &change - changes;
  }
  EpisodeRow elsewhere = row_of(1);
  elsewhere.host = "there";
  elsewhere.wall_s = 99.0;
  elsewhere.command = "other";
  EXPECT_TRUE(row.agrees_with(elsewhere));
}

TEST_F(ForeignDatabase, RefusesInvalidFormatsAndNumbers) {
  run("UPDATE batch SET value = 'many' WHERE key = 'num_episodes'");
  EXPECT_THAT(refusal([](const ResultStore& store) { (void)store.info(); }),
              HasSubstr("batch.num_episodes: expected a whole number, found \"many\""));
  run("UPDATE batch SET value = '2' WHERE key = 'format'");
  EXPECT_THAT(refusal([](const ResultStore&) {}), HasSubstr("expected results in format 1, found \"2\""));
  run("DELETE FROM batch WHERE key = 'format'");
  EXPECT_THAT(refusal([](const ResultStore&) {}), HasSubstr("expected results in format 1, found \"\""));
}

}  // namespace
}  // namespace swiftlet::sim

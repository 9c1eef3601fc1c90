// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/plugin/plugin.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Libraries of a few lines. They are loaded by what they export, so that none of our headers is needed.
class Plugins : public ::testing::Test {
 protected:
  void SetUp() override { allow_plugins("1.2"); }
  void TearDown() override { allow_plugins(""); }

  void build(const std::string& name, const std::string& content) const {
    const fs::path source = folder.path() / (name + ".cpp");
    std::ofstream(source) << content;
    const std::string command =
        "c++ -shared -fPIC -o " + (folder.path() / (name + ".so")).string() + " " + source.string();
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  /// The mark that a library of Swiftlet holds.
  static std::string mark(const std::string& version) {
    return "[[gnu::used]] static const char mark[] = \"swiftlet plugin mark: " + version + "\";\n";
  }
  static std::string plugin_for(const std::string& version, const std::string& body = "") {
    return mark(version) + "#include <stdexcept>\nextern \"C\" const char* swiftlet_plugin_version() { return \"" +
           version + "\"; }\nextern \"C\" void swiftlet_plugin_register(const void*) {" + body + "}\n";
  }
  static bool is_loaded(const fs::path& path) {
    return std::ranges::count(loaded_plugins(), path.lexically_normal().string()) == 1;
  }

  TemporaryDirectory folder;
};

TEST_F(Plugins, LoadOnceRelativeToNamingFile) {
  build("fine", plugin_for("1.2"));
  const std::size_t before = loaded_plugins().size();
  EXPECT_EQ(load_plugin("fine.so", folder.path()), "");
  EXPECT_TRUE(is_loaded(folder.path() / "fine.so"));
  EXPECT_EQ(load_plugin("./fine.so", folder.path()), "");
  EXPECT_EQ(load_plugin((folder.path() / "fine.so").string(), ""), "");
  EXPECT_EQ(loaded_plugins().size(), before + 1);
  allow_plugins("");
  EXPECT_EQ(load_plugin("fine.so", folder.path()), "") << "what is loaded needs no leave any more";
}

TEST_F(Plugins, RunNothingUnlessTheyAreAllowed) {
  build("fine", plugin_for("1.2"));
  allow_plugins("");
  EXPECT_THAT(load_plugin("fine.so", folder.path()),
              HasSubstr("--allow-plugins on the command line, because the plugin \"fine.so\""));
  EXPECT_FALSE(is_loaded(folder.path() / "fine.so"));
}

TEST_F(Plugins, AreOfThisVersion) {
  build("old", plugin_for("1.1"));
  EXPECT_EQ(load_plugin("old.so", folder.path()),
            "a plugin that was built for swiftlet 1.2, found \"old.so\" for 1.1; build it again");
  EXPECT_FALSE(is_loaded(folder.path() / "old.so"));
}

TEST_F(Plugins, RunNoCodeOnVersionMismatch) {
  const fs::path trace = folder.path() / "trace";
  const std::string runs =
      "#include <fstream>\nstatic const bool ran = [] { std::ofstream(\"" + trace.string() + "\"); return true; }();\n";
  build("old", runs + plugin_for("1.1"));
  build("older", runs + plugin_for("1.2").substr(mark("1.2").size()));
  EXPECT_THAT(load_plugin("old.so", folder.path()), HasSubstr("for 1.1; build it again"));
  EXPECT_THAT(load_plugin("older.so", folder.path()), HasSubstr("which has no SWIFTLET_PLUGIN, or that of an older"));
  EXPECT_FALSE(fs::exists(trace));
  build("fine", runs + plugin_for("1.2"));
  EXPECT_EQ(load_plugin("fine.so", folder.path()), "");
  EXPECT_TRUE(fs::exists(trace));
}

TEST_F(Plugins, NeedVersionThatMatchesTheirMark) {
  const std::string rest = "extern \"C\" void swiftlet_plugin_register(const void*) {}\n";
  build("null", mark("1.2") + "extern \"C\" const char* swiftlet_plugin_version() { return nullptr; }\n" + rest);
  EXPECT_THAT(load_plugin("null.so", folder.path()), HasSubstr("which has no SWIFTLET_PLUGIN"));
  build("other", mark("1.2") + "extern \"C\" const char* swiftlet_plugin_version() { return \"1.1\"; }\n" + rest);
  EXPECT_THAT(load_plugin("other.so", folder.path()), HasSubstr("for 1.1; build it again"));
}

TEST_F(Plugins, MustBeMarkedSharedLibraries) {
  std::ofstream(folder.path() / "text.so") << "no library";
  EXPECT_THAT(load_plugin("text.so", folder.path()), HasSubstr("a shared library, found \"text.so\": "));
  EXPECT_THAT(load_plugin("none.so", folder.path()), HasSubstr("a shared library, found \"none.so\": "));
  const std::string expected = "which has no SWIFTLET_PLUGIN";
  build("other", "int x;\n");
  EXPECT_THAT(load_plugin("other.so", folder.path()), HasSubstr(expected));
  build("half", mark("1.2") + "extern \"C\" const char* swiftlet_plugin_version() { return \"1.2\"; }\n");
  EXPECT_THAT(load_plugin("half.so", folder.path()), HasSubstr(expected));
  build("rest", mark("1.2") + "extern \"C\" void swiftlet_plugin_register(const void*) {}\n");
  EXPECT_THAT(load_plugin("rest.so", folder.path()), HasSubstr(expected));
  EXPECT_FALSE(is_loaded(folder.path() / "half.so"));
}

TEST_F(Plugins, AreRefusedForNamesInUse) {
  build("taken", plugin_for("1.2", "throw std::runtime_error(\"hover is there\");"));
  EXPECT_EQ(load_plugin("taken.so", folder.path()), "a plugin with modules, found \"taken.so\": hover is there");
  EXPECT_FALSE(is_loaded(folder.path() / "taken.so"));
}

TEST_F(Plugins, AreRefusedForThrowingNonExceptions) {
  build("odd", plugin_for("1.2", "throw 42;"));
  EXPECT_EQ(load_plugin("odd.so", folder.path()),
            "a plugin with modules, found \"odd.so\": it threw something that is no std::exception");
}

}  // namespace
}  // namespace swiftlet::sim

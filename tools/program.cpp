// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/program.hpp"

#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <locale>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "commands.hpp"
#include "interrupt.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/render/render_config.hpp"
#include "swiftlet/sim/run/processors.hpp"
#include "swiftlet/sim/run/version.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"

namespace {

constexpr int kBroke = 1;
constexpr int kWrongInput = 2;
constexpr int kClosedPipe = 128 + SIGPIPE;  // exit status that a shell reports for this signal

// Replaces the library's message, which only reports a missing subcommand.
void require_known_command(const CLI::App& app, const std::string& word) {
  if (word.empty() || word.front() == '-') return;
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
  if (std::find(known.begin(), known.end(), word) != known.end()) return;
  throw swiftlet::sim::InputError("expected " + swiftlet::sim::one_of(known) + ", found \"" + word + "\"" +
                                  swiftlet::sim::did_you_mean(word, known));
}

/// `swiftlet list | head`: the reader of the standard output has closed it, which is no error.
bool output_is_closed() {
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  return poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

// The program is built for processors with AVX2; others would stop later with an illegal instruction.
bool processor_is_known() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return true;
  std::fputs("swiftlet: expected a processor with AVX2, found one without\n", stderr);
  return false;
#else
  return true;
#endif
}

int run_program(int argc, char** argv, const std::vector<void (*)(CLI::App&)>& subcommands) {
  CLI::App app{"Swiftlet: simulator of teams of UAVs that see with LiDAR", "swiftlet"};
  const std::string pictures(swiftlet::sim::picture_library());
  app.set_version_flag("--version", std::string(swiftlet::sim::version()) + " (" + swiftlet::sim::git_revision() +
                                        (pictures.empty() ? "), without pictures" : "), pictures by " + pictures));
  app.require_subcommand(1);
  app.failure_message([](const CLI::App* program, const CLI::Error& error) {
    std::string command = program->get_name();
    for (const CLI::App* chosen = program; !chosen->get_subcommands().empty();) {
      chosen = chosen->get_subcommands().back();
      command += " " + chosen->get_name();
    }
    return "swiftlet: " + std::string(error.what()) + "\nTry '" + command + " --help'.\n";
  });
  for (const auto& add : subcommands) add(app);
  try {
    swiftlet::sim::limit_openmp();
    require_known_command(app, argc > 1 ? argv[1] : "");
    app.parse(argc, argv);
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
    if (output_is_closed()) return kClosedPipe;
    std::fprintf(stderr, "swiftlet: cannot write to the standard output: %s\n", std::strerror(errno));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongInput;
  } catch (const swiftlet::tools::Interrupted& stop) {
    std::fprintf(stderr, "swiftlet: %s\n", stop.what());
    return stop.exit_status();
  } catch (const swiftlet::sim::InputError& error) {
    std::fprintf(stderr, "swiftlet: %s\n", error.what());
    return kWrongInput;
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "swiftlet: %s\n", error.what());
    return kWrongInput;
  } catch (const swiftlet::ContractViolation& violation) {
    std::fprintf(stderr, "swiftlet: internal error: %s\n", violation.what());
  } catch (const swiftlet::sim::OutOfMemory& problem) {
    std::fprintf(stderr, "swiftlet: %s\n", problem.what());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "swiftlet: out of memory\n");
  } catch (const std::filesystem::filesystem_error& error) {
    std::fprintf(stderr, "swiftlet: %s\n", swiftlet::sim::message_of(error).c_str());
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::broken_pipe && output_is_closed()) return kClosedPipe;
    std::fprintf(stderr, "swiftlet: %s\n", error.what());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "swiftlet: %s\n", error.what());
  } catch (...) {
    std::fprintf(stderr, "swiftlet: a module threw something that is no std::exception\n");
  }
  return kBroke;
}

}  // namespace

namespace swiftlet {

int tools::run(int argc, char** argv, const std::vector<void (*)(CLI::App&)>& subcommands) {
  std::locale::global(std::locale::classic());  // decimal points in command line, files and messages
  // Writing to a closed pipe or a file at its size limit then fails as a write instead of ending the run.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  return processor_is_known() ? run_program(argc, argv, subcommands) : kBroke;
}

int main(int argc, char** argv) {
  return tools::run(argc, argv,
                    {tools::add_run, tools::add_batch, tools::add_report, tools::add_render, tools::add_replay,
                     tools::add_world, tools::add_check, tools::add_list, tools::add_reference, tools::add_bench,
                     tools::add_dataset, tools::add_uncertainty, tools::add_manual});
}

}  // namespace swiftlet

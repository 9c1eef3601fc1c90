#!/usr/bin/env python3
"""Configuring and the scripts of tools/ on partly equipped machines. Usage: machines_test.py SOURCE_DIR

Nothing is built and nothing is installed: fake programs in a folder that comes first in PATH stand for apt, sudo and others.
"""
import fcntl
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest
from importlib.machinery import EXTENSION_SUFFIXES

SOURCE = pathlib.Path(sys.argv[1]).resolve()
CMAKE = shutil.which("cmake")
ROOT = os.geteuid() == 0
OTHER_USER = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] if ROOT else []
COMPILER_MB = 1800  # memory that the largest compiler needs
PICTURE_PACKAGES = {"libosmesa6-dev", "libegl-dev", "libgl1-mesa-dri"}  # optional: one of two ways to draw


def packages(kind):
    rows = [line.split() for line in (SOURCE / "tools/packages.txt").read_text().splitlines() if not line.startswith("#")]
    return {row[0] for row in rows if row[1:] == [kind]}


class Machine(unittest.TestCase):
    """A temporary folder and an environment without settings of the calling user."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name).resolve()
        self.path.chmod(0o755)
        self.fakes = self.path / "fakes"
        self.home = self.path / "home"
        self.fakes.mkdir()
        self.home.mkdir(mode=0o777)
        self.home.chmod(0o777)
        self.environment = {
            "PATH": f"{self.fakes}:{os.environ['PATH']}", "HOME": str(self.home), "LC_ALL": "C.UTF-8", "FAKES": str(self.fakes),
            "PYTHONDONTWRITEBYTECODE": "1", "GIT_CONFIG_GLOBAL": "/dev/null", "GIT_CONFIG_SYSTEM": "/dev/null"}
        self.environment.update({f"GIT_{who}_{what}": "x" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")})

    def run_command(self, *command, status=0, **options):
        options = {"env": self.environment, "cwd": self.path, "timeout": 300, **options}
        result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                stdin=subprocess.DEVNULL, **options)
        if status is not None:
            self.assertEqual(result.returncode, status, result.stdout)
        return result.stdout

    def put(self, path, text, mode=0o644):
        path = self.path / path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text))
        path.chmod(mode)
        return path

    def fake(self, name, text):
        return self.put(f"fakes/{name}", text, 0o755)

    def calls(self):
        path = self.fakes / "calls"
        return path.read_text().splitlines() if path.exists() else []

    def path_of_few_programs(self, *names):
        """A PATH with these programs and none else."""
        folder = self.path / "few"
        folder.mkdir(exist_ok=True)
        for name in names:
            program = shutil.which(name)
            if program and not (folder / name).exists():
                (folder / name).symlink_to(program)
        return str(folder)

    def copy_scripts(self, folder):
        for name in ("setup", "build", "quickstart", "package", "packages.txt"):
            target = self.path / folder / "tools" / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(SOURCE / "tools" / name, target)
        return self.path / folder


class Configuring(Machine):
    """CMake on a copy of the tree, whose path has blanks and umlauts, beside a conda that comes first in PATH."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="Drohnen über Köln ")
        cls.addClassCleanup(folder.cleanup)
        os.chmod(folder.name, 0o755)
        cls.tree = pathlib.Path(folder.name).resolve() / "swift let"
        left_out = {SOURCE / "build", SOURCE / ".git", SOURCE / "docs/images"}
        shutil.copytree(SOURCE, cls.tree, ignore=lambda parent, names: [n for n in names if pathlib.Path(parent, n) in left_out])
        subprocess.run(["chmod", "-R", "u=rwX,go=rX", str(cls.tree)], check=True)

    def setUp(self):
        super().setUp()
        self.conda = self.path / "miniconda3"
        for package in ("fmt", "yaml-cpp", "nlohmann_json", "CLI11", "GTest"):
            for name in (f"{package}Config", f"{package.lower()}-config"):
                self.put(f"miniconda3/lib/cmake/{package}/{name}.cmake", 'message(FATAL_ERROR "conda is taken")')
        for header in ("xxhash.h", "png.h", "zlib.h", "GL/osmesa.h", "pybind11/numpy.h"):
            self.put(f"miniconda3/include/{header}", "#error conda is taken")
        for library in ("libz.so", "libpng.so", "libOSMesa.so"):
            self.put(f"miniconda3/lib/{library}", "")
        for program in ("python3", "pkg-config"):
            self.put(f"miniconda3/bin/{program}", "#!/bin/sh\necho conda is taken\nexit 1\n", 0o755)
        self.environment["PATH"] = f"{self.conda}/bin:{self.environment['PATH']}"
        self.environment["CONDA_PREFIX"] = str(self.conda)

    def configure(self, *options, tree=None, build=None, **more):
        return self.run_command(CMAKE, "-S", tree or self.tree, "-B", build or self.path / "build ö", "-G", "Ninja", *options, **more)

    def cache(self, build=None):
        return ((build or self.path / "build ö") / "CMakeCache.txt").read_text()

    def without_pcl(self):
        folders = ";".join(f"/usr/include/pcl-1.{minor}" for minor in range(10, 20))
        return f"-DCMAKE_IGNORE_PATH={folders}"

    def google_test(self, *parts):
        """A GoogleTest whose Debian packages for these parts alone are installed."""
        text = "".join(f"add_library(GTest::{part} INTERFACE IMPORTED)\n" for part in parts)
        self.put("gtest/GTestConfig.cmake", text)
        return f"-DGTest_DIR={self.path}/gtest"

    def missing(self, *options):
        """Debian packages and kinds that the one message names."""
        output = self.configure(*options, status=1)
        self.assertEqual(output.count("CMake Error"), 1, output)
        words = " ".join(output.split())
        found = re.search(r"Missing Debian packages: (.*?) `tools/setup (.*?)`", words)
        self.assertIsNotNone(found, output)
        return set(found[1].split()), set(found[2].split())

    def test_by_default_the_program_alone_is_configured_from_the_libraries_of_the_system(self):
        del self.environment["HOME"]
        self.configure()
        cache = self.cache()
        for option in ("TESTS", "EXTENDED_TESTS", "BENCHMARKS", "PYTHON"):
            self.assertIn(f"SWIFTLET_{option}:BOOL=OFF", cache)
        ninja = (self.path / "build ö/build.ninja").read_text()
        self.assertIn("build swiftlet:", ninja)
        self.assertNotRegex(ninja, r"build (test_|bench_|python/)")
        self.assertNotIn(str(self.conda), cache)
        self.assertNotIn(str(self.conda), ninja)
        self.assertIn("pool = compilers", ninja)
        self.run_command(CMAKE, "--build", self.path / "build ö", "--target", "swiftlet_version")
        self.assertIn('git_revision() { return "unknown"; }', (self.path / "build ö/version.cpp").read_text())

    def test_a_read_only_tree_configures_elsewhere_without_test_packages_and_home(self):
        build = self.home / "build"
        if not ROOT:
            self.run_command("chmod", "-R", "a-w", self.tree)
            self.addCleanup(self.run_command, "chmod", "-R", "u+w", self.tree)
        self.environment["HOME"] = "/proc/nowhere"
        self.run_command(*OTHER_USER, CMAKE, "-S", self.tree, "-B", build, "-G", "Ninja", self.without_pcl(),
                         "-DCMAKE_DISABLE_FIND_PACKAGE_GTest=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_benchmark=ON")
        self.assertIn("build swiftlet:", (build / "build.ninja").read_text())

    def test_tests_without_google_test_name_its_packages(self):
        self.assertEqual(self.missing("-DSWIFTLET_TESTS=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_GTest=ON", self.without_pcl()),
                         ({"libgtest-dev", "libgmock-dev"}, {"test"}))

    def test_tests_need_neither_benchmark_nor_pcl(self):
        tests = ("-DSWIFTLET_TESTS=ON", self.google_test("gtest", "gtest_main", "gmock"), self.without_pcl())
        output = self.configure(*tests, "-DCMAKE_DISABLE_FIND_PACKAGE_benchmark=ON")
        self.assertIn("Without PCL (libpcl-dev)", output)
        self.assertNotIn(str(self.conda), self.cache())
        results = self.run_command("ctest", "--test-dir", self.path / "build ö", "-R", r"^(readers\.(pcd|dataset)|python\.module)$",
                                   "--fixture-exclude-any", ".*")
        self.assertEqual(results.count("***Skipped"), 3, results)
        self.put("benchmark/benchmarkConfig.cmake", "add_library(benchmark::benchmark INTERFACE IMPORTED)\n"
                 "add_library(benchmark::benchmark_main INTERFACE IMPORTED)\n")
        self.configure(*tests, "-DCMAKE_DISABLE_FIND_PACKAGE_benchmark=OFF", "-DSWIFTLET_BENCHMARKS=ON",
                       f"-Dbenchmark_DIR={self.path}/benchmark")
        self.assertIn("build benchmarks:", (self.path / "build ö/build.ninja").read_text())

    def test_all_that_is_missing_is_named_at_once(self):
        bare = self.put("bare.cmake", """\
            set(CMAKE_IGNORE_PREFIX_PATH "/usr;/;/usr/local")
            set(CMAKE_IGNORE_PATH /usr/share/fonts/truetype/dejavu)
            """)
        debian, kinds = self.missing(f"-DCMAKE_PROJECT_INCLUDE={bare}", "-DSWIFTLET_TESTS=ON", "-DSWIFTLET_BENCHMARKS=ON",
                                     "-DSWIFTLET_PYTHON=ON")
        self.assertEqual(packages("library") - PICTURE_PACKAGES - debian, set())
        self.assertLessEqual({"libgtest-dev", "libgmock-dev", "libbenchmark-dev", "pybind11-dev"}, debian)
        self.assertLessEqual({"library", "test", "extended", "python"}, kinds)
        listed = set().union(*(packages(kind) for kind in kinds))
        self.assertLessEqual(debian, listed)  # so tools/setup installs each of them

    def test_a_python_without_headers_is_refused_by_name(self):
        output = self.configure("-DSWIFTLET_PYTHON=ON", f"-DSWIFTLET_PYTHON_EXECUTABLE={self.conda}/bin/python3", status=1)
        self.assertIn(f"found {self.conda}/bin/python3", " ".join(output.split()))


class Compiling(Machine):
    """cmake/Compiling.cmake in a project of its own."""

    def setUp(self):
        super().setUp()
        self.put("project/CMakeLists.txt", f"""\
            cmake_minimum_required(VERSION 3.25)
            project(machine LANGUAGES NONE)
            include("{SOURCE}/cmake/Compiling.cmake")
            get_property(pools GLOBAL PROPERTY JOB_POOLS)
            message(STATUS "pools: ${{pools}}, ${{CMAKE_JOB_POOL_COMPILE}}, ${{CMAKE_JOB_POOL_LINK}}")
            message(STATUS "launcher: ${{CMAKE_CXX_COMPILER_LAUNCHER}}")
            """)
        self.needed = (f"-DCMAKE_MAKE_PROGRAM={shutil.which('ninja')}", f"-DCMAKE_CXX_COMPILER={shutil.which('c++')}")

    def configure(self, *options):
        return self.run_command(CMAKE, "-S", "project", "-B", tempfile.mkdtemp(dir=self.path), "-G", "Ninja", *self.needed, *options)

    def compilers(self, *options):
        found = re.search(r"pools: compilers=(\d+), compilers, compilers", self.configure(*options))
        self.assertIsNotNone(found)
        return int(found[1])

    def test_compilers_at_a_time_fit_into_the_memory(self):
        before = 1
        for memory_mb in (500, 2000, 4000, 8000, 64000):
            with self.subTest(memory_mb):
                compilers = self.compilers(f"-DSWIFTLET_MEMORY_MB={memory_mb}")
                self.assertGreaterEqual(compilers, before)
                self.assertTrue(compilers == 1 or compilers * COMPILER_MB <= memory_mb, compilers)
                self.assertLessEqual(compilers, os.cpu_count())
                before = compilers

    def test_without_ccache_in_path_the_build_goes_without(self):
        self.environment["PATH"] = str(self.fakes)
        output = self.configure()
        self.assertIn("-- Without ccache", output)
        self.assertIn("launcher: \n", output)

    @unittest.skipUnless(shutil.which("ccache"), "ccache is not installed")
    def test_ccache_is_used_where_its_folder_can_be_written(self):
        self.assertRegex(self.configure(), r"launcher: .*ccache\n")
        for variable, folder in (("CCACHE_DIR", "/proc/nowhere"), ("HOME", "/proc/nowhere")):
            with self.subTest(variable):
                self.environment[variable] = folder
                output = self.configure()
                self.assertIn("-- Without ccache", output)
                self.assertIn("launcher: \n", output)
                self.environment.pop("CCACHE_DIR", None)
        self.environment.pop("HOME")  # the folder is that of the account then
        self.configure()


class Revision(Machine):
    """cmake/Version.cmake in a small repository."""

    def setUp(self):
        super().setUp()
        self.clone = self.path / "clone"
        for name in ("cmake/Version.cmake", "cmake/revision.txt", ".gitattributes"):
            self.put(self.clone / name, (SOURCE / name).read_text())
        self.commit(self.clone)
        self.head = self.run_command("git", "-C", self.clone, "rev-parse", "HEAD").strip()[:12]

    def commit(self, folder):
        for arguments in (["init", "-q"], ["add", "-A"], ["commit", "-qm", "x"]):
            self.run_command("git", "-C", folder, *arguments)

    def unpack(self, folder):
        folder.mkdir(parents=True)
        self.run_command("sh", "-c", 'git -C "$0" archive HEAD | tar x -C "$1"', self.clone, folder)
        return folder

    def revision(self, folder):
        output = self.path / "version.cpp"
        self.run_command(CMAKE, f"-DSOURCE_DIR={folder}", "-DVERSION=1", f"-DOUTPUT={output}", "-P", folder / "cmake/Version.cmake")
        return re.search(r'git_revision\(\) { return "(.*)"; }', output.read_text())[1]

    def test_a_clone_has_its_commit_and_a_mark_when_changed(self):
        self.assertEqual(self.revision(self.clone), self.head)
        self.put(self.clone / "cmake/Version.cmake", (SOURCE / "cmake/Version.cmake").read_text() + "# changed\n")
        self.assertEqual(self.revision(self.clone), self.head + "+")

    def test_an_archive_has_the_revision_of_its_clone(self):
        self.assertEqual(self.revision(self.unpack(self.path / "tar ball")), self.head)

    def test_a_foreign_repository_around_the_source_does_not_count(self):
        outer = self.path / "outer"
        archive = self.unpack(outer / "swiftlet")
        copy = shutil.copytree(self.clone, outer / "copy", ignore=shutil.ignore_patterns(".git"))
        self.commit(outer)
        self.assertEqual(self.revision(archive), self.head)
        self.assertEqual(self.revision(copy), "unknown")

    @unittest.skipUnless(ROOT, "only root can give a clone to another user")
    def test_a_clone_of_another_user_has_its_commit(self):
        self.run_command("chown", "-R", "65534:65534", self.clone)
        self.assertEqual(self.revision(self.clone), self.head)

    def test_a_link_to_a_clone_and_a_worktree_have_their_commit(self):
        (self.path / "link").symlink_to(self.clone)
        self.assertEqual(self.revision(self.path / "link"), self.head)
        self.run_command("git", "-C", self.clone, "worktree", "add", "-q", self.path / "worktree")
        self.assertEqual(self.revision(self.path / "worktree"), self.head)


class Building(Machine):
    """tools/build in a small clone with a preset of its own."""

    def setUp(self):
        super().setUp()
        self.clone = self.copy_scripts("kleine Kopie ü")
        self.put(self.clone / "CMakeLists.txt", """\
            cmake_minimum_required(VERSION 3.25)
            project(machine LANGUAGES NONE)
            file(APPEND ${PROJECT_BINARY_DIR}/configured "x")
            """)
        preset = {"name": "release", "generator": "Ninja", "binaryDir": "${sourceDir}/build/release"}
        self.put(self.clone / "CMakePresets.json", json.dumps(
            {"version": 6, "configurePresets": [preset], "buildPresets": [{"name": "release", "configurePreset": "release"}]}))

    def build(self, clone, **options):
        return self.run_command(*options.pop("by", []), clone / "tools/build", **options)

    def times_configured(self, clone):
        return len((clone / "build/release/configured").read_text())

    def test_a_moved_or_copied_clone_is_configured_anew_and_a_link_is_not(self):
        self.build(self.clone)
        (self.path / "link").symlink_to(self.clone)
        self.assertNotIn("anew", self.build(self.path / "link"))
        self.assertEqual(self.times_configured(self.clone), 2)
        copy = shutil.copytree(self.clone, self.path / "copy")
        self.assertIn("anew", self.build(copy))
        self.assertNotIn("anew", self.build(copy))
        moved = self.clone.rename(self.path / "moved")
        self.assertIn("anew", self.build(moved))
        self.assertEqual(self.times_configured(moved), 1)

    def test_a_second_build_in_the_same_folder_waits_for_the_first(self):
        self.build(self.clone)
        with open(self.clone / "build/release/lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            second = subprocess.Popen([self.clone / "tools/build"], env=self.environment, stdout=subprocess.PIPE, text=True)
            self.addCleanup(second.stdout.close)
            self.assertIn("waiting for another build", second.stdout.readline())
            self.assertEqual(self.times_configured(self.clone), 1)
        self.assertIn("up to date", second.communicate(timeout=60)[0])
        self.assertEqual(self.times_configured(self.clone), 2)

    def test_in_a_read_only_tree_the_message_names_another_way(self):
        for folder, _, files in os.walk(self.clone):
            os.chmod(folder, 0o555)
            self.addCleanup(os.chmod, folder, 0o755)
        message = self.build(self.clone, by=OTHER_USER, status=1)
        self.assertIn(f"cannot write {self.clone}/build/release", message)
        self.assertIn(f"cmake -S '{self.clone}' -B", message)

    def test_without_cmake_the_message_names_it(self):
        self.environment["PATH"] = self.path_of_few_programs("bash", "env", "dirname", "mkdir", "cat", "sed")
        self.assertRegex(self.build(self.clone, status=1), "cmake: (command )?not found")


class Scripts(Machine):
    """tools/setup, tools/quickstart and tools/package beside fakes of apt, sudo and CMake."""

    def setUp(self):
        super().setUp()
        self.clone = self.copy_scripts("clone")
        self.setup = self.clone / "tools/setup"
        self.fakes.chmod(0o777)
        self.put("fakes/installed", "bash\n", 0o666)
        self.fake("sudo", '#!/bin/sh\nexec "$@"\n')
        self.fake("dpkg", '#!/bin/sh\necho "dpkg $*" >>"$FAKES/calls"\n')
        self.fake("dpkg-query", f"""\
            #!{sys.executable}
            import os, sys
            form = sys.argv[sys.argv.index("-f") + 1].replace("\\\\n", "\\n").replace("${{db:Status-Status}}", "installed")
            for name in open(os.environ["FAKES"] + "/installed").read().split():
                print(form.replace("${{Package}}", name), end="")
            """)
        # Knows every package but those of the file unknown: one kind of them has an entry without a candidate.
        self.fake("apt-cache", """\
            #!/bin/bash
            if [ "$1" = madison ]; then
              [ ! -e "$FAKES/lists" ] || echo "apt | 2.6.1 | http://deb.debian.org bookworm/main amd64 Packages"
              exit 0
            fi
            [ -e "$FAKES/lists" ] || exit 0
            shift
            for name in "$@"; do
              if ! grep -qsx "$name" "$FAKES/unknown"; then
                printf '%s:\\n  Installed: (none)\\n  Candidate: 1.0\\n  Version table:\\n     1.0 500\\n' "$name"
              elif [[ $name = lib* ]]; then
                printf '%s:\\n  Installed: (none)\\n  Candidate: (none)\\n  Version table:\\n' "$name"
              fi
            done
            """)
        self.fake("apt-get", """\
            #!/bin/bash
            echo "apt-get $*" >>"$FAKES/calls"
            while [[ $1 = -* || $1 = *=* ]]; do shift; done
            case $1 in
              update) touch "$FAKES/lists" ;;
              install)
                [ ! -e "$FAKES/at_install" ] || . "$FAKES/at_install"
                for name in "${@:2}"; do [[ $name = -* ]] || echo "$name" >>"$FAKES/installed"; done ;;
            esac
            """)

    def installed(self):
        return set((self.fakes / "installed").read_text().split())

    def at_install(self, text):
        self.put("fakes/at_install", text)

    def interrupted(self, script):
        """Presses Ctrl-C while apt installs; returns the output of the script and the calls of the time when it had ended."""
        (self.fakes / "calls").unlink(missing_ok=True)
        process = subprocess.Popen([script], env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   start_new_session=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        with process:
            while "apt at work" not in self.calls() and process.poll() is None:
                time.sleep(0.05)
            os.killpg(process.pid, signal.SIGINT)
            self.assertEqual(process.wait(timeout=60), 130)
            return self.calls(), process.stdout.read()

    def test_what_is_missing_is_installed_once_and_then_all_is_silent(self):
        output = self.run_command(self.setup, "build", "library")
        self.assertIn("setup: done", output)
        self.assertEqual(self.installed() - {"bash"}, self.needed("build", "library"))
        calls = self.calls()
        self.assertEqual(self.run_command(self.setup, "build", "library"), "")
        self.assertEqual(self.calls(), calls)

    def needed(self, *kinds):
        """All packages of these kinds but programs that are in PATH already."""
        return {package for kind in kinds for package in packages(kind)
                if not (package in ("ccache", "clang", "clang-format", "clang-tidy", "ffmpeg", "npm") and shutil.which(package))}

    def test_an_unknown_kind_is_refused_with_the_list(self):
        output = self.run_command(self.setup, "biuld", status=2)
        for word in ("biuld", "build", "library", "python", "test", "extended"):
            self.assertIn(word, output)
        self.assertEqual(self.calls(), [])

    def test_packages_that_the_release_does_not_have_are_left_out_and_named(self):
        unknown = {"libosmesa6-dev", "librandom123-dev", "fonts-dejavu-core"}
        self.put("fakes/unknown", "\n".join(sorted(unknown)))
        output = self.run_command(self.setup, "library")
        line = next(line for line in output.splitlines() if "left out" in line)
        self.assertEqual(set(line.split(": ")[-1].split()), unknown)
        in_its_place = {"libegl-dev", "libgl1-mesa-dri"}  # of libosmesa6-dev
        self.assertEqual(self.installed() - {"bash"}, self.needed("library") - unknown | in_its_place)
        calls = self.calls()
        again = self.run_command(self.setup, "library")
        self.assertEqual((again.strip(), self.calls()), (line, calls))

    def test_without_dpkg_it_warns_and_does_not_fail(self):
        self.environment["PATH"] = self.path_of_few_programs("bash", "env", "dirname", "grep", "awk", "sort", "xargs")
        self.assertIn("not a Debian system", self.run_command(self.setup))

    def test_ctrl_c_ends_apt_and_a_second_try_works(self):
        self.at_install("""\
            trap 'sleep 0.5; echo apt ended >>"$FAKES/calls"; exit 100' INT
            echo apt at work >>"$FAKES/calls"
            for i in {1..600}; do sleep 0.1; done
            echo apt survived >>"$FAKES/calls"
            """)
        self.fake("cmake", '#!/bin/sh\necho "cmake $*" >>"$FAKES/calls"\n')
        for script in (self.setup, self.clone / "tools/quickstart"):
            with self.subTest(script.name):
                calls, output = self.interrupted(script)
                self.assertEqual(calls[-1], "apt ended")
                self.assertIn("setup: interrupted", output)
        self.at_install("")
        self.assertIn("setup: done", self.run_command(self.setup))

    def test_it_waits_for_another_package_manager_and_reports_so_meanwhile(self):
        self.at_install("""\
            for i in {1..600}; do
              echo "Waiting for cache lock: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 4711 (dselect)..."
              [ ! -e "$FAKES/lock_released" ] || break
              sleep 0.1
            done
            """)
        with subprocess.Popen([self.setup], env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as setup:
            lines = []
            for line in setup.stdout:
                lines.append(line)
                if "4711 (dselect)" in line:
                    (self.fakes / "lock_released").touch()
            self.assertEqual(setup.wait(), 0, lines)
        self.assertTrue((self.fakes / "lock_released").exists(), lines)
        self.assertEqual(sum("4711" in line for line in lines), 1, lines)
        self.assertTrue(any("-o DPkg::Lock::Timeout=" in call and "install" in call for call in self.calls()))

    def test_a_failing_apt_is_quoted_with_the_reason(self):
        self.at_install(r"""\
            printf 'Unpacking libfmt-dev ...\r\n'
            printf 'dpkg: error processing archive libfmt-dev.deb (--unpack):\r\n cannot copy: No space left on device\r\n'
            echo 'E: Sub-process /usr/bin/dpkg returned an error code (1)'
            exit 100
            """)
        output = self.run_command(self.setup, status=1)
        for text in ("dpkg: error processing archive", "No space left on device", "E: Sub-process"):
            self.assertIn(text, output)
        self.assertNotIn("setup: done", output)

    def test_without_network_the_old_package_lists_serve(self):
        (self.fakes / "lists").touch()
        self.put("fakes/apt-get", self.fakes.joinpath("apt-get").read_text().replace(
            'touch "$FAKES/lists"', "echo 'E: Failed to fetch http://deb.debian.org'; exit 100"), 0o755)
        output = self.run_command(self.setup, "library")
        self.assertIn("E: Failed to fetch", output)
        self.assertIn("old ones", output)
        self.assertIn("setup: done", output)

    @unittest.skipUnless(ROOT, "needs root to become another user")
    def test_without_root_and_sudo_the_command_is_printed_and_a_failing_sudo_is_quoted(self):
        self.fake("sudo", "#!/bin/sh\necho 'sudo: a password is required'\nexit 1\n")
        output = self.run_command(*OTHER_USER, self.setup, "library", status=1)
        self.assertIn("sudo: a password is required", output)
        (self.fakes / "lists").unlink(missing_ok=True)
        (self.fakes / "sudo").unlink()
        few = self.path_of_few_programs("bash", "env", "dirname", "grep", "awk", "sort", "xargs", "id", "cat", "setpriv")
        self.environment["PATH"] = f"{self.fakes}:{few}"
        output = self.run_command(*OTHER_USER, self.setup, "library", status=2)
        self.assertIn("apt-get install", output)
        self.assertIn("libfmt-dev", output)

    def asked_of_cmake(self):
        """What quickstart, setup --python and package ask CMake for. A missing TMPDIR does not matter."""
        self.environment["TMPDIR"] = "/nowhere"
        self.fake("cmake", '#!/bin/sh\necho "cmake $*" >>"$FAKES/calls"\n')
        self.fake("cpack", '#!/bin/sh\ntouch swiftlet_1_amd64.deb\n')
        self.put("clone/build/release/swiftlet", '#!/bin/sh\necho "swiftlet $*"\n', 0o755)
        self.put("clone/build/package/kept", "")
        self.assertIn("swiftlet run scenarios/forest_guidance.yaml --replay --seed 3",
                      self.run_command(self.clone / "tools/quickstart", "--seed", "3"))
        self.assertIn(f"PYTHONPATH={self.clone}/build/release/python", self.run_command(self.setup, "--python"))
        self.assertIn(f"{self.clone}/build/package/swiftlet_1_amd64.deb", self.run_command(self.clone / "tools/package"))
        return "\n".join(call for call in self.calls() if call.startswith("cmake"))

    def test_scripts_of_users_never_ask_for_tests_or_their_packages(self):
        calls = self.asked_of_cmake()
        self.assertIn("--preset release", calls)
        self.assertIn("--preset package", calls)
        self.assertIn("-DSWIFTLET_PYTHON=ON", calls)
        self.assertNotRegex(calls, "TESTS|BENCHMARKS|WERROR")
        self.assertEqual(self.installed() & ((packages("test") | packages("extended")) - packages("python")), set())
        for preset in json.loads((SOURCE / "CMakePresets.json").read_text())["configurePresets"]:
            if preset["name"] in ("base", "release", "package"):
                self.assertNotIn("TESTS", json.dumps(preset))


class PythonModule(Machine):
    """`import swiftlet` where the compiled part does not fit the interpreter."""

    def setUp(self):
        super().setUp()
        self.package = self.path / "python/swiftlet"
        shutil.copytree(SOURCE / "sim/python/swiftlet", self.package, ignore=shutil.ignore_patterns("__pycache__"))
        self.environment["PYTHONPATH"] = str(self.package.parent)

    def message(self, *options):
        output = self.run_command(sys.executable, *options, "-c", "import swiftlet", status=1)
        self.assertIn("ImportError: swiftlet: ", output)
        self.assertNotIn("circular", output)
        return output.splitlines()[-1]

    def test_a_module_for_another_python_is_named_with_the_remedy(self):
        self.put(self.package / "_core.cpython-34-x86_64-linux-gnu.so", "")
        message = self.message()
        self.assertIn("cpython-34", message)
        self.assertIn("%d.%d.%d" % sys.version_info[:3], message)
        self.assertIn(f"-DSWIFTLET_PYTHON_EXECUTABLE={sys.executable}", message)

    def test_a_module_that_was_not_built_names_the_command(self):
        self.assertIn("tools/setup --python", self.message())

    def test_missing_numpy_is_named(self):
        self.put(self.package / f"_core{EXTENSION_SUFFIXES[0]}", "")
        self.put("python/numpy.py", "raise ImportError('no numpy here')")
        message = self.message()
        self.assertIn("expected numpy", message)
        self.assertIn(sys.executable, message)

    def test_other_errors_keep_their_message(self):
        self.put(self.package / f"_core{EXTENSION_SUFFIXES[0]}", "no library")
        self.put("python/numpy.py", "")
        self.assertIn("file too short", self.run_command(sys.executable, "-c", "import swiftlet", status=1))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])

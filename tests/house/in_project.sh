# Installs the build, for the tests that source this: build, work, examples and here are folders, in_project builds against it.
build=$1
here=$(cd "$(dirname "$0")" && pwd)
examples=$here/../../examples
work=$build/$(basename "$0" .sh)
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")
rm -rf "$work"
cmake --install "$build" --prefix "$work/prefix" >/dev/null

# Builds an external project that finds only the installed package.
in_project() {  # source binary targets option...
  local source=$1 binary=$work/$2 targets=$3
  shift 3
  cmake -S "$source" -B "$binary" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$compiler" \
    -DCMAKE_PREFIX_PATH="$work/prefix" "$@" >/dev/null
  # shellcheck disable=SC2086  # several targets
  cmake --build "$binary" --target $targets
}

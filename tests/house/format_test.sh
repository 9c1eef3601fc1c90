#!/usr/bin/env bash
# Every C++ file is formatted by clang-format with .clang-format. Usage: format_test.sh SOURCE_DIR
# Exit status 77 (skipped) without Debian 12's version of clang-format: other versions break lines elsewhere.
set -euo pipefail
cd "$1"
format=clang-format-14
command -v "$format" >/dev/null || format=clang-format
if ! "$format" --version 2>/dev/null | grep -q 'version 14\.'; then
  echo "clang-format 14 is missing; tools/setup installs it"
  exit 77
fi
git rev-parse --git-dir >/dev/null 2>&1 || { echo "not a clone: no list of files"; exit 77; }
git ls-files -z '*.cpp' '*.hpp' | xargs -0 -n 40 -P "$(nproc)" "$format" --dry-run --Werror ||
  { echo "mend with: git ls-files -z '*.cpp' '*.hpp' | xargs -0 $format -i"; exit 1; }

# Sourced by the other scripts and .ci/run, in the project's root: how a preset is configured and built here.

# ccache where it is installed; CMake reads this at the first configuration of a build folder.
if [ -z "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ] && command -v ccache > /dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
fi
# Clones of this tree in different folders share what the cache holds.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
# As ccache wants it for precompiled headers; no file of ours uses __TIME__ or the like.
export CCACHE_SLOPPINESS=pch_defines,time_macros

# clang where it is installed: it takes half to nine tenths of GCC's time (docs/decisions/0005). CMake reads this at the
# first configuration, too; CXX=g++ scripts/... builds with GCC.
if [ -z "${CXX:-}" ] && command -v clang++ > /dev/null; then
  export CXX=clang++
fi

# build_jobs [PRESET]: one job per core, but not more than memory carries: a translation unit takes up to 1.5 GB, one of
# the preset release, which holds several modules, 3 GB.
build_jobs() {
  local cores memory unit=1500000
  [ "${1:-}" != release ] || unit=3000000
  cores=$(nproc 2> /dev/null || echo 2)
  memory=$(awk -v unit="$unit" '/^MemAvailable:/ { jobs = int($2 / unit); print jobs < 1 ? 1 : jobs }' /proc/meminfo 2> /dev/null || echo "$cores")
  echo $((cores < memory ? cores : memory))
}

# build_preset PRESET [TARGET ...]; PALPATE_CXX_FLAGS: instead of the preset's (CMake takes the preset's again wherever
# they are not given).
build_preset() {
  local preset=$1
  shift
  local log=build/$preset-configure.log
  mkdir -p build
  cmake --preset "$preset" ${PALPATE_CXX_FLAGS:+"-DCMAKE_CXX_FLAGS=$PALPATE_CXX_FLAGS"} > "$log" 2>&1 || { cat "$log" >&2; return 1; }
  cmake --build --preset "$preset" --parallel "$(build_jobs "$preset")" ${1:+--target "$@"}
}

# Sourced by .ci/run and scripts/long: phases one after the other, and a line for each at the end.

# The sanitizers' surroundings, for a command.
under_asan() {
  LSAN_OPTIONS="suppressions=$PWD/.ci/lsan.supp:print_suppressions=0" UBSAN_OPTIONS=print_stacktrace=1 "$@"
}
under_tsan() {
  local fixed=()
  # GCC 12's thread sanitizer cannot live with as many random address bits as newer kernels use.
  setarch "$(uname -m)" -R true 2> /dev/null && fixed=(setarch "$(uname -m)" -R)
  "${fixed[@]}" "$@"
}

# run_phases PHASE ...: the functions phase_PHASE; status 1 where any of them failed.
run_phases() {
  local phase start verdict summary=() failed_phases=()
  mkdir -p build
  SECONDS=0
  for phase in "$@"; do
    printf '\n=== %s ===\n' "$phase"
    start=$SECONDS
    verdict=passed
    "phase_$phase" 2>&1 | tee "build/phase-$phase.log" || { verdict=FAILED; failed_phases+=("$phase"); }
    summary+=("$(printf '%-12s %s in %d s' "$phase" "$verdict" $((SECONDS - start)))")
  done
  for phase in "${failed_phases[@]}"; do  # again at the end, where whoever sees only the end finds it
    printf '\n=== what failed in %s ===\n' "$phase"
    grep -vE '^ *Start +[0-9]+: |\.\.\. +Passed +[0-9]|^\[ *(OK|RUN|-+|=+|PASSED) *\]|Cannot export local symbol|^$' "build/phase-$phase.log" | tail -60
  done
  printf '\n'
  printf '%s\n' "${summary[@]}"
  echo "$(($# - ${#failed_phases[@]})) phases passed, ${#failed_phases[@]} failed, $SECONDS s"
  [ ${#failed_phases[@]} -eq 0 ]
}

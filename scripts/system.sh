# Sourced by scripts that try something in a Debian system of its own, as root: how one is made, and how a command runs in it.

# sources_of RELEASE: of Debian's packages for that release, where this machine has its own from (deb822).
sources_of() {
  if [ -e /etc/apt/sources.list.d/debian.sources ]; then
    grep -v '^#' /etc/apt/sources.list.d/debian.sources | awk -v RS= -v ORS='\n\n' '!/[Ss]ecurity/' | sed "s/^Suites:.*/Suites: $1/"
  else
    sed -nE "s/^deb (\[[^]]*\] )?([^ ]+) [a-z]+ main.*/Types: deb\nURIs: \2\nSuites: $1\nComponents: main\n/p" /etc/apt/sources.list
  fi
}

# make_system RELEASE FOLDER: a small system of that release, with apt and this machine's way to the packages.
make_system() {
  local sources status=0
  sources=$(mktemp --suffix=.sources)
  sources_of "$1" > "$sources"
  mmdebstrap --quiet --variant=minbase "$1" "$2" "$sources" || status=$?
  rm "$sources"
  cp /etc/resolv.conf "$2/etc/resolv.conf"
  return $status
}

# in_system FOLDER COMMAND ...: as root in that system, with /proc and /dev and processes of its own.
in_system() {
  # shellcheck disable=SC2016
  unshare --mount --pid --fork sh -c '
    mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && mount -t tmpfs tmpfs "$0/dev/shm" &&
      exec chroot "$0" "$@"' "$@"
}
